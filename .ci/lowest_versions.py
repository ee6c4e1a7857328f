"""Install the lowest declared versions of the dependencies, and use every command with them.

python .ci/lowest_versions.py [FOLDER]

The core dependencies and those of the extra "app" have the lower bounds of pyproject.toml, as
wheels for Python 3.11; their own dependencies have the newest version that fits. FOLDER keeps the
virtual environment.
"""

import json
import re
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
import urllib.request
import venv
from pathlib import Path

ROOT = Path(__file__).parents[1]
NEWSPRINT = "newsprint_table2.toml"
TABLE = "nip_load [kN/m],wound_on_tension [N/m]\n2,520\n3.5,700\n5,760\n"
STACK = "pressure [kPa],strain [%]\n10,1.73\n50,4.48\n100,5.99\n200,7.61\n500,9.83\n"
CASES = "nip_load [kN/m],web_tension [N/m]\n2,300\n3,350\n"
STUDY = f"""schema = 1
case = "{NEWSPRINT}"
outputs = ["wound_on_tension"]
[over]
nip_load = {{ from = "3 kN/m", to = "4 kN/m" }}
roll_friction = {{ from = 0.15, to = 0.3 }}
[design]
kind = "sobol"
samples = 4
[solver]
nodes = 33
"""
# every command; {kind}.toml is the example of a kind
COMMANDS = f"""\
materials
grades
describe nip
solve {NEWSPRINT} --nodes 33 --plot nip.png --save nip.nc --sensitivity
solve rollers.toml --nodes 33 --json
solve roll.toml --plot roll.svg
solve winding.toml --set tension_law=friction --plot winding.png
report {NEWSPRINT} roll.toml --out report.html --unit mill
find {NEWSPRINT} --vary nip_load=3kN/m:4kN/m --target wound_on_tension=700
compare measured.csv {NEWSPRINT} --nodes 33
stack stack.csv --plot stack.png
table cases.csv --case {NEWSPRINT} --out solved.csv
schedule roll.toml --pressure 200kPa
window winding.toml --set tension_law=friction --web-tension 300:400 --nip-load 2000:3000 \
--samples 128 --uncertain roll_friction=0.1
sweep study.toml --out swept --workers 2
sobol study.toml --out ranked --workers 1 --samples 4
fit {NEWSPRINT} measured.csv --vary roll_friction=0.1:0.4
plan plan_next_measurement.toml --draws 0
"""


def lowest_versions():
    """Return "name==version" for every lower bound of the core and of the extra "app"."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    bounds = [*project["dependencies"], *project["optional-dependencies"]["app"]]
    return [bound.replace(">=", "==") for bound in bounds]


def installed(folder):
    """Install woundon[app] with these versions into a new environment; return its commands."""
    (folder / "lowest.txt").write_text("\n".join(lowest_versions()), encoding="utf-8")
    venv.create(folder / "venv", with_pip=False)
    commands = folder / "venv" / "bin"
    pip = [sys.executable, "-m", "pip", "--python", commands / "python", "install", "-qq"]
    constraint = ["--only-binary", ":all:", "--constraint", folder / "lowest.txt"]
    subprocess.run([*pip, *constraint, f"{ROOT}[app]"], check=True)
    return commands


def run(*command, cwd=ROOT):
    """Run a command; return what it prints."""
    done = subprocess.run(command, capture_output=True, text=True, cwd=cwd)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))}\nexit code {done.returncode}\n{done.stderr}")
    return done.stdout


def solved_by_the_server(woundon):
    """Start the server, and let it solve an example; return the outputs."""
    command = [woundon, "app", "--no-browser", "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        try:
            address = re.search(r"http://\S+/", server.stdout.readline())[0]

            def answer(path, body=None):
                head = {"Content-Type": "application/json"}
                asked = urllib.request.Request(f"{address}api/{path}", body, head)
                with urllib.request.urlopen(asked, timeout=60) as read:
                    return json.load(read)

            case = answer("catalogue")["kinds"][0]["example"]
            return answer("solve", json.dumps(case).encode())["outputs"]
        finally:
            server.terminate()


def main(folder):
    """Install, then run the README's example, every command and a request."""
    work = folder / "work"
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    commands = installed(folder)
    began = time.monotonic()
    woundon = commands / "woundon"
    for example in (ROOT / "examples").glob("*.toml"):
        (work / example.name).write_bytes(example.read_bytes())
    for kind in ("rollers", "roll", "winding"):
        (work / f"{kind}.toml").write_text(run(woundon, "new", kind), encoding="utf-8")
    for name, text in (
        ("measured.csv", TABLE),
        ("cases.csv", CASES),
        ("stack.csv", STACK),
        ("study.toml", STUDY),
    ):
        (work / name).write_text(text, encoding="utf-8")
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    example, answer = re.search(r"```python\n(.*?)```.*?```text\n(.*?)```", readme, re.S).groups()
    if run(commands / "python", "-c", example) != answer:
        sys.exit("the README's example prints another answer")
    for line in COMMANDS.splitlines():
        run(woundon, *line.split(), cwd=work)
    if not solved_by_the_server(woundon)["wound_on_tension"]["value"] > 0:
        sys.exit("the server does not solve the example")
    seconds = time.monotonic() - began
    print(f"all commands and a request in {seconds:.0f} s with {', '.join(lowest_versions())}")


if __name__ == "__main__":
    if sys.argv[1:]:
        main(Path(sys.argv[1]).absolute())
    else:
        with tempfile.TemporaryDirectory() as temporary:
            main(Path(temporary))
