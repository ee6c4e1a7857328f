"""
How do I solve a table of cases from a spreadsheet?
===================================================

Each row of a spreadsheet is a setting of the winder, in the units of the mill. The results are
to be written next to it.

**Answer:** read the table with pandas and solve it with ``wo.solve_table``. Headers name fields
of the problem with their units; other columns are copied. ``woundon table`` does the same for
Excel and CSV files.
"""

# %%
# The spreadsheet, here as a text. ``pd.read_excel("settings.xlsx")`` reads a file.
import io

import matplotlib.pyplot as plt
import pandas as pd

import woundon as wo

text = """set,nip load [kN/m],web tension [N/m],roll.radius [mm]
A1,1.8,250,150
A2,2.6,250,300
A3,3.4,300,450
B1,1.8,350,150
B2,2.6,350,300
B3,3.4,400,450
"""
settings = pd.read_csv(io.StringIO(text))

# %%
# Values without a column are those of the problem. ``columns={"set": None}`` copies a column.
outputs = ["wound_on_tension", "nip_width", "peak_pressure"]
solved = wo.solve_table(settings, wo.NipProblem.example(), outputs, columns={"set": None})
print(solved.round(4).to_string(index=False))

# %%
# ``solved.to_excel("results.xlsx")`` writes the table.
tensions = ["web tension [N/m]", "wound_on_tension [N/m]"]
labels = ["web tension", "wound-on tension"]
solved.plot.bar(x="set", y=tensions, label=labels, rot=0, ylabel="tension [N/m]")
plt.show()

# sphinx_gallery_start_ignore
assert (solved["wound_on_tension [N/m]"] > solved["web tension [N/m]"]).all()
# sphinx_gallery_end_ignore
