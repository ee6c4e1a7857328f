#!/usr/bin/env bash
# polars: text in a column of an .xlsx sheet becomes null without a message if it first appears after about row 100.
#
# Guess: a column of numbers with text further down is read as text, as by pandas (object), or rejected, as by polars.read_csv.
# Versions: polars 2.1.0, fastexcel 0.21.0.
# Behaviour: read_excel determines the type from infer_schema_length = 100 rows (the header counts) and then converts the column
#   cell by cell; cells that are not numbers become null. Text that reads as a number is converted. Where the first text is
#   decides between a column of text and a column of numbers with gaps. read_csv raises an error for the same table.
# Output: 1500 rows, text in every tenth row from row 50: String without null; from row 200: Float64 with 130 nulls, for "---"
#   as for "203,5 N/m". read_csv: ComputeError.
# Why it matters: a winder log with an alarm text or a decimal comma in a late row loses these readings, and means are taken
#   over the rest. Whether it is noticed depends on the minute in which the first alarm came.
# Remedy: infer_schema_length=None, after which the column is text and has to be converted deliberately.
. "$(dirname "$0")/environment" polars==2.1.0 fastexcel==0.21.0 xlsxwriter==3.3.1
python - <<'EOF'
import polars as pl
import xlsxwriter


def read(first, text, **options):
    """Return the type and the nulls of a column with text in every tenth row from a row on."""
    with xlsxwriter.Workbook("log.xlsx") as book:
        sheet = book.add_worksheet()
        sheet.write_row(0, 0, ["time", "tension"])
        for k in range(1500):
            sheet.write_row(k + 1, 0, [k, text if k >= first and k % 10 == 0 else 200 + k % 3 + 0.25])
    column = pl.read_excel("log.xlsx", **options)["tension"]
    print(first, text, options, column.dtype, column.null_count())
    return str(column.dtype), column.null_count()


for observed, stated in (
    (read(50, "---"), ("String", 0)),
    (read(200, "---"), ("Float64", 130)),
    (read(200, "203,5 N/m"), ("Float64", 130)),
    (read(200, "203.5"), ("Float64", 0)),
    (read(200, "---", infer_schema_length=None), ("String", 0)),
):
    if observed != stated:
        raise SystemExit(f"changed: {observed} instead of {stated}")
read(200, "---", infer_schema_length=None)
pl.read_excel("log.xlsx", infer_schema_length=None).write_csv("log.csv")
try:
    pl.read_csv("log.csv")
except pl.exceptions.ComputeError:
    print("as stated")
else:
    raise SystemExit("changed: read_csv accepts the same table")
EOF
