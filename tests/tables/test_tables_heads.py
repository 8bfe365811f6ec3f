"""Ordinary heads: what a report is told about robot, people, place and gauge is never refused."""

import pytest
from asked import CYCLES, HEAD, READINGS, ask, figures, repeatability, table

ENGLISH = """
robot: FUM SCARA
Robot: Epson LS6-B602S
robot_model: IRB 910SC
robot type: SCARA, 4 axes
manufacturer: Staubli
model: TS2-60
serial_number: 4711
Serial No.: A-0815/26
controller: CS9
controller_version: s8.12.2
software: V+ 17.3
program: iso9283_p1.pgx
gripper: Schunk EGP 40
tool: calibrated ball 20 mm
payload: 2 kg
rated_payload: 5 kg
velocity: 100 %
rated velocity: 1000 mm/s
acceleration: 80 %
dwell: 2 s
settling time: 0.5 s
warm-up: 60 min
temperature: 20.1 degC
ambient temperature: 21 °C
humidity: 45 %
air pressure: 1013 hPa
indicator: Mitutoyo ID-C112X
indicator_serial_number: 15023344
instrument: digital dial indicator, 12 mm
stand: granite, magnetic base
fixture: three dials at 90 degrees
contact point: ruby ball 3 mm
interface: Opto RS232
calibration_date: 2026-03-01
calibration_due: 2027-03-01
calibration certificate: D-K-15070-01-00
certificate_number: 26-0417
operator: A. Smith
inspector: Maria Lopez
technician: J. Doe
authorized by: Prof. Mousavi
customer: Acme Robotics Ltd
order number: PO-2026-118
contact: jane@example.org
laboratory: Precision Lab, room 114
address: 12 Mill Lane, Bristol
department: Quality
place: hall 3, cell 7
date: 2026-03-01
test_date: 2026-03-02
date of issue: 2026-03-05
time: 14:30
shift: morning
test: acceptance
test_number: 17
report_number: R-2026-017
revision: B
standard: ISO 9283:1998
procedure: 7.2.2
purpose: after the gearbox in joint 1 was replaced
gearbox: Harmonic Drive CSG-25
hours of operation: 12450
last service: 2026-01-15
lubricant: SK-1A
mounting: floor
comment: second run of the day
remarks: cable tied to the arm
note: nothing unusual
project: P-77
batch: 12
machine: cell 4
asset: 000123
location: Tehran
country: Iran
weather: rain
""".strip().splitlines()
GERMAN = """
Roboter: FUM SCARA
Hersteller: Bosch Rexroth
Typ: SR6
Modell: turboscara
Seriennummer: 4711
Steuerung: IndraMotion
Programm: Messung_P1
Greifer: Zimmer GEP
Nutzlast: 2 kg
Nennlast: 5 kg
Geschwindigkeit: 100 %
Beschleunigung: 80 %
Verweilzeit: 2 s
Temperatur: 20,1 °C
Luftfeuchte: 45 %
Messuhr: Mahr 1086 R
Messmittel: Messuhr digital
Kalibrierdatum: 01.03.2026
Kalibrierschein: 4711-D-K
Nächste Kalibrierung: 01.03.2027
Prüfer: Müller
Bediener: Schmidt
Freigegeben von: Dr. Weiß
Kunde: Beispiel GmbH
Auftraggeber: Werk Süd
Auftragsnummer: 2026-118
Abteilung: Qualitätssicherung
Ort: Halle 3
Prüfort: Labor 114
Datum: 01.03.2026
Messdatum: 02.03.2026
Uhrzeit: 14:30
Schicht: Früh
Prüfnummer: 17
Berichtsnummer: R-2026-017
Norm: ISO 9283
Zweck: nach Getriebetausch
Getriebe: Planetengetriebe
Betriebsstunden: 12450
Letzte Wartung: 15.01.2026
Schmierstoff: Klübersynth
Bemerkung: zweiter Lauf
Anlage: Zelle 4
Projekt: P-77
""".strip().splitlines()
FRENCH = """
robot: SCARA TS60
opérateur: Jean Dupont
constructeur: Stäubli
modèle: TS2-60
numéro de série: 4711
contrôleur: CS9
programme: mesure_p1
charge: 2 kg
charge utile: 2 kg
vitesse: 100 %
température: 20 °C
humidité: 45 %
comparateur: Sylvac S229
date d'étalonnage: 2026-03-01
certificat: 26-0417
client: Exemple SA
commande: 2026-118
laboratoire: Métrologie
lieu: atelier 3
numéro du rapport: R-2026-017
vérificateur: Marie Curie
norme: ISO 9283
remarque: deuxième essai
atelier: hall B
équipe: matin
""".strip().splitlines()
ITALIAN = """
operatore: Mario Rossi
costruttore: Comau
modello: Rebel-S6
numero di serie: 4711
controllore: R1C
programma: misura_p1
carico: 2 kg
velocità: 100 %
umidità: 45 %
comparatore: Borletti
data di taratura: 2026-03-01
certificato: 26-0417
cliente: Esempio SpA
ordine: 2026-118
laboratorio: Metrologia
luogo: reparto 3
numero del rapporto: R-2026-017
norma: ISO 9283
osservazioni: seconda prova
reparto: qualità
turno: mattina
""".strip().splitlines()
SPANISH = """
operador: Ana García
fabricante: Omron
modelo: i4-550
número de serie: 4711
controlador: eV+
carga: 2 kg
velocidad: 100 %
humedad: 45 %
reloj comparador: Mitutoyo
fecha de calibración: 2026-03-01
certificado: 26-0417
empresa: Ejemplo SA
pedido: 2026-118
lugar: nave 3
número de informe: R-2026-017
norma aplicada: ISO 9283
observaciones: segunda prueba
responsable: Luis Pérez
""".strip().splitlines()
LURES = """
control unit: KRC5 micro
teach pendant unit: TP-2
business unit: Robotics
gear_ratio: 50
gear ratio of joint 1: 1:50
tool offset: 120 mm
tool_offset_z: 85 mm
zero set by: A. Smith
valid until: 2027-03-01
validity of the certificate: 2 years
accuracy class of the dial: 1
side of the cell: operator's
poses planned: P1 to P5
reference standard: gauge block 5 mm
balance: Sartorius
scaffold: none
Einheitswagen: 3
Nullserie: ja
Getriebeübersetzung: 50
Gültig bis: 01.03.2027
unità operativa: 3
unidad de control: RC700
rapport: R-2026-017
""".strip().splitlines()
AFTER_THE_RULE = """
Auftragsnummer: 2026-117
Prüfling: SCARA 450, Nr. 12
Prüfort: Halle 3, Platz 7
Aufspannung: Granitplatte 600 x 400
Messuhr Hersteller: Mahr
Taster: Rubinkugel 3 mm
Tasterverlängerung: 30 mm
Messkraft: 0,8 N
Spannung: 24 V
Netzspannung: 230 V
Nennlast: 3 kg
Zusatzlast: 1 kg
Zykluszeit: 4,2 s
Taktzeit: 6 s
Verweilzeit: 2 s
Einlaufzeit: 60 min
Bahngeschwindigkeit: 250 mm/s
Drehzahl: 1500 1/min
Übersetzung Getriebe: 50
Getriebespiel: 1 arcmin
Achsabstand: 300 mm
Hub: 200 mm
Reichweite: 700 mm
Softwarestand: 4.7.1
Programmname: pose_P1
Bediener: Özkan
Prüfer und Freigabe: Weber
Kunde: Müller GmbH
Abteilung: QS 2
Raum: 0.17
Luftdruck: 1013 mbar
Prüfmittelnummer: PM-0042
Prüfintervall: 12 Monate
nächste Kalibrierung: 2027-03
Kommentar: Uhr nach Zyklus 5 nachgezogen
Anmerkung: zweite Messung nach Umbau
opérateur: Lefèvre
client: Dupont SA
lieu: atelier 4
numéro de série: 1234-5
charge nominale: 5 kg
vitesse nominale: 1000 mm/s
température ambiante: 21,5 °C
comparateur: Sylvac S_Dial
date d'étalonnage: 2026-02-11
certificat: COFRAC 26-118
remarque: deuxième essai après réglage
montage: support magnétique
durée de chauffe: 45 min
logiciel: VAL3 s8.9
cadence: 12 par minute
pression: 6 bar
cliente: Rossi SpA
luogo: officina 2
numero di serie: IT-556
carico utile: 2 kg
velocità: 80 %
comparatore: Borletti
data di taratura: 2026-01-20
certificato: ACCREDIA 77
nota: prova ripetuta dopo la manutenzione
temperatura iniziale: 19,8 °C
temperatura finale: 20,6 °C
tempo di sosta: 2 s
operario: García
lugar: nave 1
número de serie: ES-9
carga útil: 2 kg
velocidad: 100 %
reloj comparador: Käfer
fecha de calibración: 2026-03-03
observaciones: segundo ensayo
humedad: 40 %
project: repeatability 2026
purchase order: PO-4711
test number: 3 of 5
cell: 12
station: B
shift: night
arm length: 700 mm
reach: 650 mm
stroke: 180 mm
nominal load: 3 kg
duty cycle: 60 %
homing: done at start
brake: released
firmware: 2.4.0
cable: RSCN-16
serial port: COM4
baud rate: 9600
stand height: 350 mm
stem: 8 mm
contact force: 1.0 N
plunger travel: 12.5 mm
sampling: 10 Hz
filter: off
room: metrology lab
photo: IMG_0815.jpg
weather: sunny, 24 °C
reference: ISO 9283:1998
standard: ISO 9283
procedure: SOP-17 rev 2
approved by: Chen
customer reference: C-88
test purpose: acceptance after repair
last service: 2026-06-30
operating hours: 12450 h
display: LCD
display: mm
mode: absolute
drawing units: inch
robot unit: inch
position of the robot: inch
correction: none
Korrektur: keine
start: 14:30
target: 0.02 mm
least favourable pose: P3
smallest payload: 0.5 kg
given name: Anna
dimensions: 700 x 300 mm
Dimension: 2
one operator: Smith
one revolution: 8 s
C: 4711
division: gearboxes
divided: no
Teilnehmer: Weber, Kurz
graduated: 2019
result: accepted
error: none
quality: ISO 9001
alarm: none
ref: 4711
before: 2025
initial letters: AS
display language: de
measured by: Chen
given by: Rossi
expressed wish: quick report
correct: yes
one dial of three: spare
""".strip().splitlines()
"""Written once the rule stood, to try it."""
HEADS = [*ENGLISH, *GERMAN, *FRENCH, *ITALIAN, *SPANISH, *LURES, *AFTER_THE_RULE]
RIGHT = {"X": repeatability(READINGS[1:])}


@pytest.fixture
def path(folder):
    return folder / "run.csv"


@pytest.mark.parametrize("head", HEADS)
def test_an_ordinary_head_is_accepted_and_kept(head, path):
    table(path, {"cycle": CYCLES, "X": READINGS}, [*HEAD, f"# {head}"])
    answer = ask("analyze", path, "--json")
    assert answer.code == 0, answer.err
    assert figures(answer) == pytest.approx(RIGHT)
    assert head.partition(": ")[2] in answer.document["metadata"].values()


@pytest.mark.parametrize(
    ("spell", "delimiter"),
    [(lambda key, value: f"{key}: {value}", ","), (lambda key, value: f"{key};{value}", ";")],
    ids=["without a mark", "in cells"],
)
@pytest.mark.parametrize("heads", [ENGLISH, GERMAN, FRENCH, ITALIAN, SPANISH])
def test_ordinary_heads_are_accepted_in_other_places(heads, spell, delimiter, path):
    firsts = {head.partition(": ")[0].casefold(): head for head in heads}
    lines = [spell(*head.split(": ", 1)) for head in firsts.values()]
    unit = spell("unit", "mm")
    table(path, {"cycle": CYCLES, "X": READINGS}, [unit, *lines], delimiter)
    answer = ask("analyze", path, "--json")
    assert answer.code == 0, answer.err
    assert figures(answer) == pytest.approx(RIGHT)
