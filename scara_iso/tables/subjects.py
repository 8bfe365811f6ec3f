"""What a key, a heading or a line of text speaks of, by the stems of its words.

A statement that could change a figure is used, or refused with what to write; it is never passed
over. The words are those of English, German, French, Italian and Spanish. A key speaks of the
readings where a stem of a subject stands alone or beside words of readings, axes and gauges:
``tool offset`` and ``gear_ratio`` name another thing. Some stems can hardly mean anything else and
need no company; only a word of the robot or of its surroundings makes them another thing's.
"""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass
from enum import Enum
from functools import lru_cache

from scara_iso.run import AXES
from scara_iso.tables.faults import quoted
from scara_iso.tables.names import LONGEST_NAME, clean, read_unit
from scara_iso.tables.numbers import parse_cell


class Subject(Enum):
    """What changes a figure; of two in one key the first counts."""

    UNCERTAINTY = "an uncertainty"
    EXCLUDED = "excluded readings"
    SCALE = "a factor of readings"
    UNIT = "a unit"
    ZERO = "a zero"
    SIDE = "a side"


_OWN = {
    Subject.UNCERTAINTY: """uncertain unsicher incertitud incertezz incertidumbr coverag
        erweiterungsfaktor elargiss copertur cobertur""",
    Subject.EXCLUDED: """exclu esclu ausgeschloss ausschluss struck gestrich durchgestrich invalid
        ungultig outlier ausreiss aberrant verworf""",
    Subject.SCALE: """scal skal echell escal massstab masstab umrechn conversion konversion
        multipl moltiplic divisor diviseur divid divise diviso geteilt teiler magnif amplif verstark
        vergross""",
}
"""Stems that need no company."""
_WEAK = {
    Subject.UNCERTAINTY: "u uc k",
    Subject.EXCLUDED: """reject valid gultig omit omis omess omes discard ignor skip bad void scart
        rechaz rejet descart raye tachad barrat annul annull anul strik streich""",
    Subject.SCALE: """factor faktor facteur fattor gain guadagn gananc ratio verhaltnis ubersetz
        sensitivit sensibil empfindlich lever hebel levier leva palanc per pro lsb""",
    Subject.UNIT: "unit unid einheit uom 单位",
    Subject.ZERO: "zero null cero offset tare tara baselin versatz decalag",
    Subject.SIDE: """side seit cote lato lado flank flanc fianc direction direzion direccion
        richtung dir sens""",
}
"""Stems that are of a subject alone or in company."""
_COMPANY = """
x y z theta axis axes achse axe asse eje read value wert mess mass messwert messung measur mesur
misur medi lectur lettur ables anzeig affich displa output data daten donne dati dato angab valeur
valor dial gauge gage indicator indikator indicateur uhr comparat comparad komparat taster prob
sensor palpeur reloj orolog instrument channel kanal canal column spalt cycl zykl cicl run lauf
row zeil point punkt calibrat kalibr etalonn tarat cal kal length lang longueur lunghezz longitud
engineer standard expand erweiter combin estes espand number num nombr numer all alle tutt tout
given angegeb express exprim espress dimens correct korrekt correz c div teilstrich skt
todo of the der des die das du de d la le les l di del dell dei el los las for fur pour por par je
a an at to by mit with da in en is are sind und and et e not no non nicht kein pas nr rapport p
count digit tick step puls increment inkrement mm um micron mikron inch zoll anfahr approach
arriv angl winkel angul angol calibrac calibraz approch avvicin aproxim
"""
"""Stems of readings, axes and gauges, and the little words between."""
_ANOTHER = """
robot joint gear getrieb motor tool werkzeug speed veloc geschwind vites velocid accelerat load
last nutzlast payload charge carico carga temperatur humid feucht pressur druck weigh waag drawing
zeichnung time zeit safety sicher servo position control power strom volt force kraft torque
"""
"""Stems of what is no reading: the robot, its conditions, its surroundings."""
_SUFFIXES = """
s es e en n er ern ed d ing ings ly ung ungs ungen ion ions or ors eur eurs eure a o i as os t te
ten re res ri ita ad ades ata ato ati ate iert ierung ierungs ieren ado ada ados adas ee ees uto uti
uta us ut y r ation ations ione ioni icator icateur ier ied ive iv ivity ivitat ilite ilita ilidad
keit zone ement so si sa se sen sens ido ida idos idas ite heit heits ty ties ia ie da das do dos
ded de des der sion sione siones ted ting ta tt ication icazione icacion ikator ikation ore ori
atore icatore icador age agio ura ure ur ador ped ping ene enen ener enes amento acion y ys yed
ying
"""
_ENDINGS = frozenset(_SUFFIXES.split())
_FOLDED = str.maketrans({"ß": "ss", "ø": "o", "θ": "theta", "ϑ": "theta"})
_LONGEST_WORD = 40
_LENGTHS = frozenset(["mm", "um", "micron", "mikron", "inch", "zoll"])
_ANGLES = ("angl", "winkel", "angul", "angol")


def _stems() -> dict[str, Subject | None]:
    found: dict[str, Subject | None] = dict.fromkeys(_fold(_COMPANY).split())
    for stems in (_WEAK, _OWN):
        for subject, text in stems.items():
            found |= dict.fromkeys(_fold(text).split(), subject)
    return found


def _fold(text: str) -> str:
    """Return a text in small letters without accents; German ``ue`` is as ``ü``."""
    plain = unicodedata.normalize("NFKD", text.casefold().translate(_FOLDED))
    plain = "".join(c for c in plain if not unicodedata.combining(c))
    return re.sub("([aou])e", r"\1", plain)


@dataclass(frozen=True, slots=True)
class Topic:
    """What a key speaks of, and the axes that it names."""

    subject: Subject
    axes: tuple[str, ...] = ()


@lru_cache(maxsize=1024)
def topic_of(text: str) -> Topic | None:
    """Return what a key or heading speaks of, None where it is of another thing, or of none."""
    if len(text) > LONGEST_NAME:
        return None
    words = re.findall(r"[^\W\d_]+", _fold(_NO_WORD.sub(" ", text).replace("/", " per ")))
    parts = [_parts(word) for word in words]
    known = [stem for found in parts for stem in found or ()]
    subjects = {subject for stem in known if (subject := _STEMS[stem])}
    if "per" in known and not _LENGTHS & set(known):
        subjects -= {Subject.SCALE}
    if words and words[-1] in ("in", "en") and None not in parts:
        subjects.add(Subject.UNIT)
    if None in parts:
        others = [w for w, found in zip(words, parts, strict=True) if found is None]
        subjects = {one for one in _OWN if any(_begins(w, _OWN_STEMS[one]) for w in words)}
        if any(_begins(word, _OTHERS) for word in others):
            return None
    subject = next((one for one in Subject if one in subjects), None)
    return Topic(subject, _axes_of(words, known)) if subject else None


def _axes_of(words: list[str], known: list[str]) -> tuple[str, ...]:
    named = [axis for axis in AXES if axis.lower() in (*words, *known)]
    angle = any(stem in _ANGLES for stem in known) and "theta" not in named
    return (*named, "theta") if angle else tuple(named)


def _begins(word: str, stems: tuple[str, ...]) -> bool:
    return word.startswith(stems)


@lru_cache(maxsize=4096)
def _parts(word: str) -> tuple[str, ...] | None:
    """Return the stems that make up a word with their endings, None where some of it is unknown."""
    if len(word) > _LONGEST_WORD:
        return None
    if word in _STEMS:
        return (word,)
    for end in range(len(word), _SHORTEST - 1, -1):
        if word[:end] in _STEMS and (more := _behind(word[end:])) is not None:
            return (word[:end], *more)
    return None


def _behind(rest: str) -> tuple[str, ...] | None:
    """Return the stems behind the first: none where an ending, or an axis, is all there is."""
    if rest in _ENDINGS:
        return ()
    if rest in _LETTERS:
        return (rest,)
    for k in range(min(_LONGEST_ENDING, len(rest) - _SHORTEST) + 1):
        if not k or rest[:k] in _ENDINGS:
            more = _parts(rest[k:])
            if more is not None:
                return more
    return None


_STEMS = _stems()
_OWN_STEMS = {subject: tuple(_fold(text).split()) for subject, text in _OWN.items()}
_OTHERS = tuple(_fold(_ANOTHER).split())
_OF_READINGS = """
read value wert mess messwert messung measur mesur misur medi lectur lettur ables anzeig affich
displa dial gauge gage indicator indikator indicateur uhr comparat komparat taster prob sensor
palpeur mm um
"""
_INSTRUMENTS = frozenset(_OF_READINGS.split())
_SHORTEST = 3
"""Letters of a stem that others, or an ending, may follow."""
_LETTERS = ("x", "y", "z")
_LONGEST_ENDING = max(map(len, _ENDINGS))

_NO_WORD = re.compile(r"\S*(?://|www\.)\S*|\bk[0-9]+", re.IGNORECASE)
"""An address, or the k-th of some things: the coverage factor is k alone."""
_NUMBER = r"[-+±−]?[0-9]+(?:[.,][0-9]+)?(?:e[-+]?[0-9]+)?"
_FACTOR = re.compile(
    rf"\W*x? ?{_NUMBER}(?: ?[:/x×·*^]{{1,2}} ?[-−+⁻]?[0-9.,⁰¹²³⁴⁵⁶⁷⁸⁹]{{1,20}}){{0,2}} ?"
    r"([^\W\d].{0,24})?",
    re.IGNORECASE,
)
_FREE_NUMBER = re.compile(r"(?<![\w.,-])[0-9]+(?:[.,][0-9]+)?(?:(?![\w-])|(?=[a-zµμ°]))")
_NOTHING = """
- — 0 no none nothing nil n/a na keine keiner nein nicht nichts rien niente nada aucun
aucune non nessuno nessuna ninguno ninguna
false
"""
_ALL = "yes true all ja alle oui toutes tous si sì sí tutti tutte todos todas 1"
_DATE = re.compile(r"[0-9]{1,4}[-./][0-9]{1,2}[-./][0-9]{1,4}")
_OF_ONE = re.compile(r"(?:x ?)?1(?:[.,]0*)?(?: ?[:/] ?1)?|100 ?%", re.IGNORECASE)
LEAVE_SCALES = "state the factor in the unit, as '# unit: 0.01 mm', and leave this out"
_REMEDIES = {
    Subject.UNCERTAINTY: "write the standard uncertainty, which is U divided by its coverage "
    "factor k, as '# indicator_uncertainty: 0.002', and leave this out",
    Subject.EXCLUDED: "remove the rows that do not count, say `allow_gaps=`, and leave this out; a "
    "first cycle that was discarded is '# first_cycle_discarded: true'",
    Subject.SCALE: LEAVE_SCALES,
    Subject.UNIT: "write the unit as '# unit: mm', of one axis as '# unit_X: um', and leave "
    "this out",
    Subject.ZERO: "write readings from which the zero is taken, and leave this out",
}
_UNDERSTOOD = frozenset({"first_cycle_discarded", "dial_zero", "parts_struck"})
"""Keys of the program whose words are a subject's."""
_RECORDER = "record_"
"""How the recorder's own remarks begin: struck readings are in its raw file, and in no row."""


def refusal(key: str, written: str, value: str) -> tuple[str, str] | None:
    """Return what is wrong with a statement that changes a figure and is not understood.

    Beside it is what to write; None for any other statement. ``key`` as `normal_key` has it.
    """
    understood = key in _UNDERSTOOD or key.startswith(_RECORDER)
    if understood or (found := topic_of(written)) is None:
        return None
    text = clean(value[:_LONGEST_LINE])
    if found.subject not in _REMEDIES or not _acts(found.subject, written, text):
        return None
    what = "and readings are multiplied by no factor"
    what = what if found.subject is Subject.SCALE else "which is not understood"
    return f"{quoted(f'{clean(written)}: {text}')}, {what}", _REMEDIES[found.subject]


def _acts(subject: Subject, written: str, text: str) -> bool:
    """Say whether a value could change a figure."""
    low = text.casefold()
    counts = subject is Subject.EXCLUDED and affirms(written)
    if says_nothing(low) and not counts:
        return False
    match subject:
        case Subject.UNIT:
            return True
        case Subject.EXCLUDED:
            all_count = counts and low in _ALL.split()
            return bool(low) and not _DATE.fullmatch(low) and not all_count
        case Subject.UNCERTAINTY:
            return _FREE_NUMBER.search(low) is not None and not _of_another(low)
        case Subject.ZERO:
            number = parse_cell(text)
            return number is not None and number.value != 0 and not _of_another(low)
        case _:
            named = speaks_of_scale(text)
            return named or (
                _FACTOR.fullmatch(low) is not None
                and not _OF_ONE.fullmatch(low)
                and not _of_another(low)
            )


def is_of_another(written: str) -> bool:
    """Say whether a key names the robot, its conditions or its surroundings."""
    return any(_begins(word, _OTHERS) for word in re.findall(r"[^\W\d_]+", _fold(written)))


def affirms(written: str) -> bool:
    """Say whether a key names what counts, as ``valid`` does."""
    words = re.findall(r"[^\W\d_]+", _fold(written))
    denied = any(word in ("not", "non", "no", "nicht", "pas") for word in words)
    return any(word.startswith(("valid", "gultig")) for word in words) and not denied


def says_nothing(text: str) -> bool:
    """Say whether a value states that there is nothing: 0, none, nein, no."""
    return not text.strip() or text.strip().casefold().rstrip(".") in _NOTHING.split()


def names_an_instrument(heading: str) -> bool:
    """Say whether a heading is a reading's and names no axis: ``dial``, ``Messwert``."""
    words = re.findall(r"[^\W\d_]+", _fold(heading)) if len(heading) <= LONGEST_NAME else []
    parts = [_parts(word) for word in words]
    of_it = [stem for found in parts for stem in found or ()]
    return bool(words) and None not in parts and {*of_it} <= _INSTRUMENTS


def _of_another(text: str) -> bool:
    """Say whether a number has a unit of no reading: V, kg, °C, s."""
    number = parse_cell(text)
    unit = number.unit if number else ""
    return bool(unit) and unit != "%" and read_unit(unit) is None and len(unit.split()) == 1


_POWER = re.compile(
    r"(?:mal|times|[x×·*]) ?10 ?(?:\^ ?[({]?|\*\* ?|e|(?=[-−⁻⁰¹²³⁴⁵⁶⁷⁸⁹]))[-−+⁻]?[0-9⁰¹²³⁴⁵⁶⁷⁸⁹]"
)
_PARTS = re.compile(
    r"(?<![0-9] )(?<![0-9])\b(?:hundredth|thousandth|tenth|hundertstel|tausendstel|zehntel|centiem|"
    r"milliem|dixiem|centesim|millesim|decim|milesim)\w*(?: \w{1,5}){0,2} ?-?"
    r"(?:mm|millim|inch|in\b|zoll|pouce|pollic|pulgad)"
)
_ALONE = re.compile(rf"\W*(?:[x×·*] ?{_NUMBER}|(?:in )?mm ?/ ?10+|1e-?[0-9] ?[a-zµμ]+)\W*")
"""A line that is nothing but a factor, or a part of a unit."""
_ONE_COUNT = re.compile(
    r"\W*(?:1|one|eine?|une?|uno|una) (?:digit|count|tick|lsb|unit|unid|einheit|divis|teil|step"
    r"|puls|pas|incr|inkr|skt|bit)\w*(?: \w+)? ?(?:[=:,;≙≈]|is|equals?|entspricht|ist|vaut)+ ?"
    rf"(?!1 ?mm){_NUMBER}.*"
)
"""What one step of a display is, in a text whose words blanks part."""
_TIMES = re.compile(r"(\w+) ?[x×·*] ?[0-9]*[.,]?[0-9]+")
_WORD_AND_NUMBER = re.compile(
    rf"([^\W\d_]+)(?: (?:by|of|is|with|mit|um|par|per|por|di|de|von|=))? {_NUMBER}(?![\w-])"
)


def speaks_of_scale(text: str) -> bool:
    """Say whether a line of text states a factor of all values: ``mm x 10^-2``, ``values x 0.01``.

    A size in front of which a number stands, as ``2 hundredths of a mm``, is none.
    """
    text = text[:_LONGEST_LINE]
    low = _fold(clean(text.translate(_SUPERSCRIPT_SIGN)))
    if _POWER.search(clean(text).lower()) or _PARTS.search(low):
        return True
    if _ALONE.fullmatch(low) or _ONE_COUNT.fullmatch(re.sub(r"[\s_-]+", " ", low)):
        return True
    if any(_is_of_readings(found[1]) for found in _TIMES.finditer(low)):
        return True
    stems = _OWN_STEMS[Subject.SCALE]
    return any(_begins(found[1], stems) for found in _WORD_AND_NUMBER.finditer(low))


_LONGEST_LINE = 400
_SUPERSCRIPT_SIGN = str.maketrans({"⁻": "-"})


def _is_of_readings(word: str) -> bool:
    return word.startswith(("value", "valu", "read", "wert", "mess", "data", "daten", "val"))
