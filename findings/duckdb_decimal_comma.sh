#!/usr/bin/env bash
# DuckDB: a table with semicolons and decimal commas is split at the commas, also with decimal_separator=','.
#
# Guess: the delimiter is found to be the semicolon, the only character between the two names of the header; numbers are text
#   without decimal_separator and DOUBLE with it.
# Version: duckdb 2.0.1.
# Behaviour: the sniffer prefers the delimiter that gives more columns with equal counts in all rows. If every number has a
#   decimal comma, k numbers give k + 1 pieces between commas and only k between semicolons: the comma wins, the header does not
#   fit and is skipped, the columns are column0 to columnk. decimal_separator=',' does not exclude the comma as delimiter. One
#   column of whole numbers makes the counts equal, and then the semicolon wins.
# Output: "1,0000;200,5" becomes (1, '0000;200', 5). With a further column "1": 'Durchmesser [m]', 'Bahnzug [N/m]', 'Rolle'.
# Why it matters: German, French and Finnish exports of winder logs have this form, and whether they are read right depends on a
#   column of whole numbers (reel number, alarm) that has nothing to do with the rest.
# Remedy: sep=';' together with decimal=','.
. "$(dirname "$0")/environment" duckdb==2.0.1
python - <<'EOF'
import duckdb


def read(name, **options):
    table = duckdb.read_csv(name, **options)
    print(name, options, table.columns, table.types, table.limit(1).fetchall())
    return table.columns, table.limit(1).fetchall()[0]


header = "Durchmesser [m];Bahnzug [N/m]"
rows = [f"{1 + k / 1e4:.4f};{200 + k % 3}.5".replace(".", ",") for k in range(3000)]
for name, first, suffix in (("two.csv", header, ""), ("three.csv", header + ";Dicke [mm]", ";0,05")):
    with open(name, "w") as file:
        file.write("\n".join([first] + [row + suffix for row in rows]) + "\n")
with open("reel.csv", "w") as file:
    file.write("\n".join([header + ";Rolle"] + [row + ";1" for row in rows]) + "\n")

split = ["column0", "column1", "column2"]
names = header.split(";")
for observed, stated in (
    (read("two.csv"), (split, (1, "0000;200", 5))),
    (read("two.csv", decimal=","), (split, (1, "0000;200", 5))),
    (read("three.csv", decimal=","), ([*split, "column3"], (1, "0000;200", "5;0", "05"))),
    (read("reel.csv", decimal=","), ([*names, "Rolle"], (1.0, 200.5, 1))),
    (read("two.csv", decimal=",", sep=";"), (names, (1.0, 200.5))),
):
    if observed != stated:
        raise SystemExit(f"changed: {observed} instead of {stated}")
print("as stated")
EOF
