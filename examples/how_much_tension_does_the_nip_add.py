"""How much tension does the nip add, and how far off are the usual rules of thumb?

The newsprint case over a range of nip loads: the tension that the roll keeps, what of it the nip
adds, and the friction rule NIT = mu P.  The rule overstates it at every load, the more the heavier:
the web sticks over a growing part of the nip.
"""

from pathlib import Path

import woundon as wo

case = wo.load_case(Path(__file__).parent / "newsprint_table2.toml")

print("nip load   wound-on tension   the nip adds      mu P     roll side slips over")
for nip_load in (350, 876, 1751, 3502, 5837):
    problem = case.replace(nip_load=nip_load)
    result = wo.solve(problem)
    slip = abs(result.leading_roll) + abs(result.trailing_roll)
    print(
        f"{nip_load:5d} N/m {result.wound_on_tension:14.1f} N/m"
        f" {result.nip_induced_tension:10.1f} N/m"
        f" {wo.theories.friction_limit(problem):8.1f} N/m {slip:10.0%} of the nip"
    )
