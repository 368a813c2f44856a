"""One round of fitting tissue values to volumes, from a report that `ecorche build` wrote.

    python3 fit_values.py EXAMPLE/reference_volumes.csv OUT/report.json EXAMPLE/values.json

Every muscle's factor becomes factor · (wanted / volume)^0.35, kept between 0.4 and 2, and values.json is written anew;
then the example's program makes the project again. Three or four rounds settle. The table has the columns muscle and
volume_cm3, and aim_cm3 where the wanted volume is another.
"""
import csv
import json
import pathlib
import sys


def main():
    table, report, values = map(pathlib.Path, sys.argv[1:4])
    wanted = {row["muscle"]: float(row.get("aim_cm3") or row["volume_cm3"]) for row in csv.DictReader(table.open())}
    volume = {t["name"]: t["volume_cm3"] for t in json.loads(report.read_text())["tissues"]}
    factors = json.loads(values.read_text()) if values.exists() else {}
    for name, aim in wanted.items():
        if name not in volume:
            sys.exit(f"{report} knows no {name}")
        factor = factors.get(name, 1.0) * (aim / max(volume[name], 0.02)) ** 0.35
        factors[name] = round(min(2.0, max(0.4, factor)), 2)
        print(f"{name:34} wanted {aim:7.1f}  is {volume[name]:7.1f}  factor {factors[name]:.2f}")
    values.write_text(json.dumps(factors, indent=2) + "\n")


if __name__ == "__main__":
    main()
