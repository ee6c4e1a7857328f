"""
How do I run a table of cases from a spreadsheet?
=================================================

Each row of a spreadsheet is a winder setting, in the mill's units. Every row shall be solved
and the answers written beside it.

**Answer:** read it with pandas, solve row by row with ``wo.sweep(..., design="table")``, and
write the result back.
"""

# %%
# The spreadsheet, as a text here. ``pd.read_excel("settings.xlsx")`` reads a real one.
import io
from math import pi

import matplotlib.pyplot as plt
import pandas as pd

import woundon as wo

text = """set,nip load [kN/m],web tension [N/m],roll diameter [mm]
A1,1.8,250,300
A2,2.6,250,600
A3,3.4,300,900
B1,1.8,350,300
B2,2.6,350,600
B3,3.4,400,900
"""
settings = pd.read_csv(io.StringIO(text))

# %%
# Columns become fields, in SI units.
over = {
    "nip_load": 1e3 * settings["nip load [kN/m]"].to_numpy(),
    "web_tension": settings["web tension [N/m]"].to_numpy(),
    "roll.radius": 0.5e-3 * settings["roll diameter [mm]"].to_numpy(),
}
problem = wo.NipProblem.example().replace(roll_wrap=pi)
outputs = ["wound_on_tension", "nip_width", "peak_pressure"]
solved = wo.sweep(problem, over, outputs, design="table")
settings["wound-on tension [N/m]"] = solved.wound_on_tension.values.round(1)
settings["nip width [mm]"] = (1e3 * solved.nip_width.values).round(2)
settings["largest pressure [kPa]"] = (1e-3 * solved.peak_pressure.values).round(0)
print(settings.to_string(index=False))

# %%
# ``settings.to_excel("answers.xlsx")`` writes it back.
settings.plot.bar(x="set", y=["web tension [N/m]", "wound-on tension [N/m]"], rot=0, ylabel="[N/m]")
plt.show()

# sphinx_gallery_start_ignore
assert solved.failure.values.tolist() == [""] * len(settings)
assert (settings["wound-on tension [N/m]"] > settings["web tension [N/m]"]).all()
# sphinx_gallery_end_ignore
