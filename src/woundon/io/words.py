"""Words for measured quantities, as instruments and mills write them, in four languages.

English, German, Finnish and French words stand for names of fields, outputs and columns.  Words
that may mean several quantities of a winder, such as "Tension" alone, are left out: the user
assigns such a column.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable

__all__ = ["names_of_word"]

# Names -> words for each of them.  A word denotes the first of the names that a table may have.
_WORDS: dict[tuple[str, ...], str] = {
    ("nip_load",): """
        line load, nip force, Linienlast, Linienkraft, Liniendruck, Streckenlast, Niplast,
        viivakuorma, viivapaine, nippikuorma, nippivoima, charge linéique, force linéique,
        pression linéique, charge du nip""",
    ("web_tension",): """
        Bahnzug, Bahnzugkraft, Bahnspannung, rataveto, ratakireys, radan kireys, tension de bande,
        tension de la bande, traction de la bande""",
    ("diameter", "measured_diameter", "roll.diameter"): """
        roll diameter, reel diameter, Durchmesser, Rollendurchmesser, Wickeldurchmesser,
        halkaisija, rullan halkaisija, diamètre, diamètre de la bobine""",
    ("measured_radius", "radius", "roll.radius"): """
        radius, roll radius, reel radius, Rollenradius, Wickelradius, säde, rullan säde, rayon,
        rayon de la bobine""",
    ("web_speed",): """
        speed, line speed, machine speed, Geschwindigkeit, Bahngeschwindigkeit,
        Maschinengeschwindigkeit, nopeus, ratanopeus, rullausnopeus, vitesse, vitesse de bande,
        vitesse de la bande""",
    ("width",): """
        web width, Breite, Bahnbreite, leveys, radan leveys, rainan leveys, largeur, laize,
        largeur de la bande""",
    ("web.thickness", "web_thickness"): """
        caliper, Dicke, Papierdicke, Bahndicke, paksuus, radan paksuus, épaisseur,
        épaisseur de la bande""",
    ("length",): """
        web length, Länge, Bahnlänge, Lauflänge, pituus, radan pituus, longueur,
        longueur de bande""",
    ("pressure",): "Druck, paine, pression",
    ("time",): "Zeit, aika, temps",
    ("frequency",): "Frequenz, taajuus, fréquence",
    ("temperature",): "Temperatur, lämpötila, température",
    ("storage_modulus",): "Speichermodul, varastomoduuli, module de conservation",
    ("loss_modulus",): "Verlustmodul, häviömoduuli, module de perte",
}
# Words of tests of a stack under pressure, where the force and the stress are those through it.
_STACK_WORDS: dict[tuple[str, ...], str] = {
    ("pressure",): """
        stress, compressive stress, Druckspannung, Spannung, jännitys, puristusjännitys,
        contrainte, contrainte de compression""",
    ("strain",): """
        compressive strain, Dehnung, Stauchung, venymä, puristuma, déformation,
        déformation de compression""",
    ("force",): """
        load, compressive load, standard force, Kraft, Last, Standardkraft, voima, kuorma,
        puristusvoima, charge, effort""",
    ("deflection",): """
        displacement, extension, compressive extension, compression, crosshead, Weg, Standardweg,
        Verformung, Traversenweg, siirtymä, painuma, kokoonpuristuma, déplacement, enfoncement,
        flèche""",
}


def _key(text: str) -> str:
    """Return a text without case, accents and the characters between words."""
    decomposed = unicodedata.normalize("NFKD", text.casefold())
    return "".join(character for character in decomposed if character.isalnum())


def _by_word(words: dict[tuple[str, ...], str]) -> dict[str, tuple[str, ...]]:
    """Return the names of each word."""
    return {_key(word): names for names, text in words.items() for word in text.split(",")}


_NAMES, _STACK_NAMES = _by_word(_WORDS), _by_word(_STACK_WORDS)


def names_of_word(word: str, known: Iterable[str]) -> list[str]:
    """Return the name among ``known`` that a word denotes, as a list; empty if it denotes none.

    Words of a stack test count where the strain is among the known names.

    Examples
    --------
    >>> names_of_word("Bahnzug", ["nip_load", "web_tension"])
    ['web_tension']
    >>> names_of_word("Kraft", ["force", "deflection", "strain"])
    ['force']
    """
    known, key = set(known), _key(word)
    names = _NAMES.get(key, ())
    if "strain" in known:
        names = (*_STACK_NAMES.get(key, ()), *names)
    return [name for name in names if name in known][:1]
