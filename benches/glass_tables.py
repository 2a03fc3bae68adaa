#!/usr/bin/env python3
"""Makes the tables of built-in glasses in src/spectrum/glass/built_in/.

    python3 benches/glass_tables.py DATABASE

DATABASE is a checkout of github.com/polyanskiy/refractiveindex.info-database, which is in the public
domain (CC0). The tables are made from its commit ff11b58 of 2026-06-14; another one may have other
glasses. The marks "*" of widespread glasses, and the lines of other.txt, schott_old.txt and nominal.txt, are
kept as they are in the present tables.
"""

import pathlib
import re
import sys

FOLDER = pathlib.Path(__file__).parent.parent / "src/spectrum/glass/built_in"
HEADER = """# Glasses of {maker}, from the refractiveindex.info database (public domain, CC0 1.0):
# {source}.
# Made by benches/glass_tables.py. Name (* widespread), nd, Vd, range (um), formula, coefficients.
"""
# File, maker, and folders of the database.
MAKERS = [
    ("schott", "Schott", ["optical", "infrared", "misc", "obsolete"]),
    ("ohara", "Ohara", ["optical"]),
    ("hoya", "Hoya", ["optical"]),
    ("hikari", "Hikari", ["optical", "CaF", "SiO2", "i-line"]),
    ("cdgm", "CDGM", ["optical"]),
    ("sumita", "Sumita", ["optical"]),
    ("lzos", "LZOS", ["optical"]),
    ("ami", "AMI", ["infrared"]),
    ("vitron", "Vitron", ["infrared"]),
    ("lightpath", "LightPath", ["infrared"]),
    ("corning", "Corning", [""]),
]
# Name, and file of the database below data/.
MATERIALS = [
    ("GERMANIUM", "main/Ge/nk/Burnett"),
    ("SILICON", "main/Si/nk/Salzberg"),
    ("ZNSE", "main/ZnSe/nk/Connolly"),
    ("ZNS_BROAD", "main/ZnS/nk/Debenham"),
    ("GAAS", "main/GaAs/nk/Skauli"),
    ("CDTE", "main/CdTe/nk/Marple"),
    ("BAF2", "main/BaF2/nk/Malitson"),
    ("MGF2", "main/MgF2/nk/Dodge-o"),
    ("MGF2-E", "main/MgF2/nk/Dodge-e"),
    ("LIF", "main/LiF/nk/Li"),
    ("NACL", "main/NaCl/nk/Li"),
    ("KBR", "main/KBr/nk/Li"),
    ("SAPPHIRE", "main/Al2O3/nk/Malitson-o"),
    ("SAPPHIRE-E", "main/Al2O3/nk/Malitson-e"),
    ("QUARTZ", "main/SiO2/nk/Ghosh-o"),
    ("QUARTZ-E", "main/SiO2/nk/Ghosh-e"),
    ("WATER", "main/H2O/nk/Daimon-20.0C"),
    ("KRS5", "specs/crystran/optical/KRS5"),
    ("CSI", "specs/crystran/optical/CsI"),
    ("CSBR", "specs/crystran/optical/CsBr"),
    ("CALCITE", "specs/crystran/optical/CaCO3-o"),
    ("CALCITE-E", "specs/crystran/optical/CaCO3-e"),
]


def block(text):
    """Returns the first description of n in a file: its formula, range and coefficients, or samples."""
    parts = re.split(r"^  - type: ", text, flags=re.M)[1:]
    for part in parts:
        kind = part.split("\n", 1)[0].strip()
        if kind.startswith("formula"):
            low, high = re.search(r"wavelength_range: *(.*)", part)[1].split()
            coefficients = re.search(r"coefficients: *(.*)", part)[1].split()
            return kind.split()[1], float(low), float(high), coefficients
        if kind in ("tabulated n", "tabulated nk"):
            body = part.split("data: |", 1)[1]
            rows = []
            for line in body.split("\n"):
                words = line.split()
                if len(words) >= 2 and re.fullmatch(r"[\d.eE+-]+", words[0]):
                    rows.append(words[:2])
                elif words and rows:
                    break
            rows.sort(key=lambda row: float(row[0]))
            if len(rows) < 3:
                return None
            unique = [row for i, row in enumerate(rows) if i == 0 or float(row[0]) > float(rows[i - 1][0])]
            return "T", float(unique[0][0]), float(unique[-1][0]), [w for row in unique for w in row]
    return None


def shorter(word):
    """Returns a number in its shortest spelling that has the same value."""
    value = float(word)
    return min([repr(value).replace("e-0", "e-"), word, re.sub(r"^(-?)0\.", r"\1.", repr(value))], key=len)


def line(name, text):
    found = block(text)
    if found is None:
        return None
    kind, low, high, c = found
    if kind == "1":
        letter, constant = "Q", float(c[0])
        c = c[1:]
        if constant != 0:
            letter, c = "A", [str(1 + constant)] + [
                w if i % 2 == 0 else repr(float(w) ** 2) for i, w in enumerate(c)
            ]
    elif kind == "2":
        letter, constant, c = "S", float(c[0]), c[1:]
        if constant != 0:
            letter, c = "A", [repr(1 + constant)] + c
    elif kind == "3":
        pairs = [(c[0], 0.0)] + [(c[i], float(c[i + 1])) for i in range(1, len(c) - 1, 2)]
        schott = [0.0, 2.0, -2.0, -4.0, -6.0, -8.0]
        if all(p in schott for _, p in pairs):
            letter = "P"
            c = [next((a for a, p in pairs if p == power), "0") for power in schott]
        else:
            letter, c = "G", [w for a, p in pairs for w in (a, str(p))]
    elif kind == "4":
        letter = "R"
    elif kind == "5":
        letter = "C"
        c = [c[0], "0"] + c[1:]
    elif kind == "T":
        letter = "T"
    else:
        return None
    nd = re.search(r"^    nd: *([\d.]+)", text, flags=re.M)
    vd = re.search(r"^    Vd: *([\d.]+)", text, flags=re.M)
    nd, vd = [m[1] if m else "-" for m in (nd, vd)]
    if vd != "-" and float(vd) < 10:  # 4.553 for N-LAF32: a point in the wrong place
        vd = repr(round(10 * float(vd), 6))
    head = [name.replace(" ", "_"), nd, vd, shorter(str(low)), shorter(str(high)), letter]
    return " ".join(head + [shorter(w) for w in c])


def source(text):
    reference = re.search(r"REFERENCES: *\|?\s*(.*)", text)[1]
    return re.sub(r"<[^>]*>|\(obtained.*|See also.*", "", reference).strip().rstrip(".")


def main():
    data = pathlib.Path(sys.argv[1]) / "database/data"
    for file, maker, folders in MAKERS:
        table = FOLDER / f"{file}.txt"
        present = table.read_text() if table.exists() else ""
        common = set(re.findall(r"^\*(\S+)", present, flags=re.M))
        order = re.findall(r"^\*(\S+)", present, flags=re.M)
        glasses, sources = {}, []
        for folder in folders:
            for path in sorted((data / "specs" / file / folder).glob("*.yml")):
                if path.stem == "about":
                    continue
                text = path.read_text()
                if path.stem == "CTK8":  # the index at 1.5296 um is above that at 1.3951 um
                    text = text.replace("        1.5296 1.68236\n", "")
                if path.stem == "BOROFLOAT33":  # nd and Vd of the data sheet, rounded to 1e-3
                    text = re.sub(r"^    (nd|Vd):.*", "", text, flags=re.M)
                found = line(path.stem, text)
                if found is None:
                    print("left out:", path)
                    continue
                glasses.setdefault(path.stem, found)
                sources.append(source(text))
        common_source = max(set(sources), key=sources.count)
        # Widespread glasses come first: the choice of a likely one depends on their order.
        first = ["*" + glasses.pop(name) for name in order]
        assert len(first) == len(common)
        header = HEADER.format(maker=maker, source=common_source)
        table.write_text(header + "\n".join(first + [*glasses.values()]) + "\n")
        print(file, len(first), "+", len(glasses), table.stat().st_size)
    lines = []
    for name, path in MATERIALS:
        text = (data / (path + ".yml")).read_text()
        lines.append(f"# {source(text)[:100]}\n{line(name, text)}")
    header = "# Crystals, infrared materials and water, from the refractiveindex.info database (CC0 1.0).\n"
    (FOLDER / "materials.txt").write_text(header + "\n".join(lines) + "\n")
    print("materials", len(lines))


main()
