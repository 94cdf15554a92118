r"""The words of makers for all that stands in an export, in all languages that are known: data.

To teach the package a word, or a language, add it here: ``word_meanings`` looks it up, and no other
module has any. A word is a regular expression for text in lower case, in which `|` stands between
words, `\b` at the end of a whole word, and `.?` for a sign that may be there; words of one meaning
stand by language (ISO 639, several where they share a word).
"""

# ---- names of columns ---------------------------------------------------------------------------

COLUMNS = {
    "time": {
        "en": r"\b(?:time|t|ms|sec)\b",
        "de fr es it": r"\b(?:zeit|temps|tiempo|tempo)\b",
        "pl ru": "czas|время",
        "zh ja": "时间|時間",
    },
    "travel": {
        "en": r"travel|stroke|motion|posi[tcz]|displac|transduc|angle|^trv?\W*\d",
        "de nl": r"\bweg|hub|winkel|verplaats",
        "fr": "course",
        "es it pt": "carrera|recorrido|desplaz|[aá]ngulo|corsa|curso",
        "ru": r"\bход|перемещ|положен",
        "zh": "行程|位移",
    },
    "of no travel": {
        "en": r"curr|coil|speed|veloc|accel|vibrat|resist|\bres\b|ohm|dcrm|press|temp|aux|contact"
        r"|status|digital|trigger|\bi\d|\bi_?l\d",
        "de": "strom|spule|geschw|widerst|druck|kontakt",
        "fr es": "courant|bobin|vitesse|corrient",
        "zh ja": "电流|速度|電流",
    },
    "contact": {
        "en": r"contact|\bmain\b|\barc|\bbreak\b|chamber|interrupter|\bpir"
        r"|^c\d(?!.*(?:cur|coil|strom|amp))",
        "de it": "kontakt|kammer|contatt",
        "zh": "触头",
    },
    "resistance": {"en": r"resistance|\bres\b|ohm", "de": "widerst"},
    "arcing": {"en": r"\barc", "de": "lichtbogen|abbrenn", "zh": "弧"},
    "break": {"en": r"\bbreak\b|chamber|interrupter", "de": "kammer"},
    "resistor contact": {"en": r"resistor|\bpir|insertion", "de": "einschaltwid"},
    "coil": {
        "en": r"coil|\btrip\b|\btrig|solenoid|\bcurr|\bcmd\b|command|^i[ _-]?[co]\b"
        r"|^i[ _-]?(?:clos|open|trip)|\b[ct]c ?\d?\b",
        "de": "spule|auslös|strom|befehl",
        "fr es": "bobin|courant|corr[ie]ent",
        "zh": "线圈|电流",
    },
    "current": {
        "en": r"\bcurr|^i\b|^i[ _-]",
        "de": "strom",
        "fr es": "courant|corr[ie]ent",
        "zh": "电流",
    },
    "motor": {"en de es": "motor", "fr": "moteur", "ru": "двигат", "zh": "电机|储能"},
    "test current": {
        "en": "dcrm",
        "en de": r"(?:test|mess|prüf)\W?(?:curr|strom)",
        "fr": "courant d.essai",
    },
    "of the drive": {"en": r"\baux|motor|heater", "de": r"\bhilfs|heizung", "fr": "moteur"},
    # What a travel without a unit is, by what its name speaks of: no mm are known of these.
    "deg": {
        "en": "angle|rotat",
        "de": r"winkel|drehung|\bdreh",
        "es it": "[aá]ngul|angol|rotaz",
        "ru zh": "угол|角",
    },
    "V": {"en de fr": r"volt|spannung|\btension", "es ru": "tensi[oó]n|напряж", "zh": "电压"},
    "counts": {"en": r"count|pulse|\badc\b|digit|\bincr|encoder|\braw\b", "de": r"impuls|\binkrem"},
}
"""What a column holds, by its name."""

TELLING = {"ru": "время|ход|путь", "zh": "行程|位移|时间|电流|速度|采样", "ja": "変位|時間"}
"""Words that tell in which encoding a text is, in their own case."""

# ---- motions and phases -------------------------------------------------------------------------

MOTION_WORDS = {
    "closing": {
        "en": r"clos\w*",
        "de": r"ein(?:schalt\w*)?",
        "fr": r"ferm\w*|enclench\w*",
        "es it": r"cierr\w*|chius\w*",
        "ru": r"вкл\w*",
        "zh": "合[闸閘]",
    },
    "opening": {
        "en": r"open\w*|trip(?:s|ped|ping)?",
        "de": r"aus(?:schalt\w*)?",
        "fr": r"ouvert\w*|déclench\w*",
        "es it": r"apert\w*",
        "ru": r"откл\w*",
        "zh": "分[闸閘]",
    },
}
"""Motions, as whole words; in Chinese, which has no blanks, within others."""

LETTERS = {"closing": "c合", "opening": "o分"}
"""Signs for motions in a sequence such as C-O."""

FOREIGN_LETTERS = {"closing": "ef", "opening": "a"}
"""Others, in a sequence of letters only: E(in) and A(us), F(ermeture)."""

SYSTEMS = ("L1 L2 L3", "R Y B", "R S T", "A B C", "U V W")
"""Phases of a breaker, of which a word for a phase is one."""

NUMBERED_PHASES = "L[123]"
"""The first of these systems, as a regular expression."""

COLOURS = ("red", "yellow", "blue")
"""Phases in words, in names of columns."""

LABELS = {
    "phase": {"en": "phase|pole|ph", "de": "pol|leiter"},
    "phase behind its letter": {"en": "phase|pole|ph", "zh": "相"},
    "channel": {"en": "ch|channel|travel|trans(?:ducer)?|tr?|pole", "de": "kanal|pol"},
    "stated channel": {"en": "ch|channel|travel|transducer|pole|trans", "de": "kanal"},
    "transducer": {"en": "tr(?:av(?:el)?|ans(?:ducer)?)?|t", "de": "wg|weg"},
    "break": {"en": "break|brk|br|chamber|unit"},
    "not connected": {"en": r"n\.?/?a\.?|nil|none|not connected|-+"},
    # In the name of a file: before a number of a channel or a version, and before a counter.
    "no counter": {
        "en": "ch|chan|channel|phase|pole|v|ver|version|rev|sn|serial|l",
        "de": "kanal|pol",
    },
    "counter": {
        "en": "op|oper|operation|no|n|num|number|count|counter|cycle|cycles|shot|test|trial",
        "de": "nr|nummer|schaltung|schaltspiel|zyklus|versuch",
        "fr es": "numero|essai",
    },
    "breaker": {"en": "breaker|cb"},
}
"""Words that stand before a number, a letter of a phase or a sign, and mean nothing by themselves.
"""

# ---- names of what stands above the samples -----------------------------------------------------

STATED = {
    "station": {
        "en": r"\b(?:sub)?station\b|\bs/s\b",
        "de": "umspannwerk|schaltanlage",
        "fr": r"\bposte\b",
        "es it pt": "subesta[cç]|stazione",
        "ru zh": "подстанц|变电站",
    },
    "site": {"en": r"\bsite\b|\blocation\b"},
    "bay": {
        "en": r"\bbay\b|\bfeeder\b",
        "de": r"\bfeld\b|abzweig",
        "fr es": r"\btravée\b|\bbah[ií]a\b|\bvano\b",
        "zh": "间隔",
    },
    "type": {
        "en de fr": r"^(?:(?:cb|breaker|circuit.?breaker|ls|schalter|disjoncteur)\W*)?"
        r"(?:typ|type|model|modell|tipo|型号)(?: designation)?$|schaltertyp"
    },
    "serial": {
        "en de fr": r"^(?:cb|(?:circuit.?)?breaker|ls|(?:leistungs)?schalter|interruptor"
        r"|disjoncteur)\W*(?:(?:no|nr|num\w*|id|tag)\W*)?$",
        "en": r"(?:\b|^cb)serial|\bs/n\b|\bsr\.? ?no\b",
        "de": r"^gerät(?:e?\W*n(?:r|ummer))?\W*$|fabri[ck]\w*\W*n(?:r|o)"
        r"|seri[ae][ens]*\W*n(?:r|umm)|werknummer",
        "fr es": r"^(?:n[°ºo]\.?|no|num[ée]ro) (?:de |du )?(?:disjoncteur|interruptor)"
        r"|matr[ií]c|n\S* de s[ée]rie",
        "ru zh": "заводск|出厂编号",
    },
    "of another thing": {
        "en": "analy[sz]er|instrument|transducer|sensor|mechanism|drive|test|report|software"
        "|firmware|battery|relay|channel",
        "de": "aufnehmer|antrieb",
    },
    "date": {"en de": r"\bdat[ea]\b|datum", "es ru": r"\bfecha\b|дата", "zh": "日期"},
    "of another day": {
        "en": r"manufact|install|commission|print|calib|next|due|export|overhaul|service|maint"
        r"|\bbuilt",
        "de": "herstell",
    },
    "of the test": {
        "en": "test|measur|record",
        "de": "prüf|mess",
        "fr es": "essai|ensayo|prueba",
        "zh": "试验",
    },
    "time": {
        "en de fr es zh": r"^(?:test|measurement|record(?:ing)?|start|prüf|mess)?\W*"
        r"(?:time|uhrzeit|zeit|heure|hora|时间)(?: of (?:test|day|measurement))?$"
    },
    "length": {
        "en": r"(?:plot|record(?:ing)?|test|trace|measurement|sampling|measuring)\W*"
        r"(?:length|duration|window|span)|^duration",
        "de": "(?:mess|aufzeichnungs|aufnahme)-?dauer",
    },
    "ratio": {
        "en": r"linkage|(?:transfer|conversion|transducer|travel|lever)\W*ratio|^ratio$",
        "de": "übersetz",
    },
    "unit": {
        "en de": r"(?:travel|stroke|hub|weg|displacement)\W*(?:unit|einheit)",
        "en": "unit of (?:travel|stroke)",
    },
    "operation": {
        "en de fr": r"^(?:kind of |type of |test |cb )?(?:operation|plan|operating sequence"
        r"|sequence|duty|schaltfolge|man\w{1,2}uvre|schaltung|operaci[oó]n|maniobra|manovra"
        r"|операция|操作)(?: (?:type|mode|sequence|kind))?$",
        "en": "^(?:test|operation)(?: (?:type|mode|sequence))?$",
    },
    "phases": {"en de": "^(?:phase|pole|pol|channel)(?:s| names?)?$"},
    "point of speed": {
        "en de fr": r"(?:veloc|speed|geschw|vitesse|veloci)"
        r".*(?:point|punkt|\bpt|range|from|\bto\b|upper|lower|zone|def)"
        r"|(?:point|punkt|zone)\w*.*(?:veloc|speed|geschw|vitesse)",
        "en": r"^(?:close|open)\W?[12]$",
    },
    "Gas pressure": {
        "en de": r"(?:gas|sf6).*(?:press|druck)|gasdruck",
        "fr es": r"\bpression|presi[oó]n",
    },
    "Temperature": {"en": r"temperat|\btemp\b"},
    "Operator": {
        "en": r"\boperator\b|tested by|engineer",
        "de": "prüfer",
        "fr es": "opérateur|operador|technici",
    },
}
"""What a name above the samples means: of the breaker, the test and the record."""

RATE_WORDS = {
    "samples": {
        "en": r"sampl|\bfs\b|\brate\b|scan",
        "de": "abtast|messrate|takt",
        "fr es": "acquisition|échantillon|echantillon|muestr|campion",
        "ru zh ja": "дискрет|采样|采樣|サンプリング",
    },
    "frequency": {"en": "freq", "fr": "fréq", "zh": "频率|頻率"},
    "step": {
        "en": r"interv|increm|period|delta|\bdt\b|time.?step|resolution",
        "de": "schritt|raster|auflös",
        "zh": "间隔|周期",
    },
    "tempo": {
        "en": r"rate|speed|\bfs\b|freq",
        "de fr es": "takt|fréq|velocidad",
        "zh ja": "频率|速率|周波数",
    },
    "dt": {"en": "dt"},
    "other": {
        "en": r"filter|bandw|cut.?off|low.?pass|rated|number|count|no\b|baud|refresh"
        r"|travel (?:res|speed)|veloc",
        "de": "grenz|tiefpass|anzahl",
        "zh": "滤波",
    },
}
"""What a name says of a rate, or of the time from one sample to the next."""

RESULTS = {  # of a name that has several, the first counts
    "": {
        "en": r"point|range|limit|\bmin|rated|nominal|toler|refer|sampl|ratio|unit|transducer"
        r"|sensor|gauge|scale|level|delay|length|\bto\b|\bfrom\b|type|resol|definition",
        "de": "punkt|soll",
    },
    "datum_speed": {"en": r"datum\W.*(?:veloc|speed)"},
    "maximum_speed": {"en de": r"\b(?:max|peak)\w*\W.*(?:veloc|speed|geschw)"},
    "maximum_travel": {"en": r"\b(?:max|peak)\w*\W.*(?:travel|stroke)"},
    "over_travel": {
        "en": r"over.?\s?(?:travel|stroke|shoot)",
        "de": "überhub|überschwing",
        "es zh": r"sobre\w*carrera|超程",
    },
    "rebound": {"en": r"re.?bound|back.?\s?travel", "de": "rückprall", "es zh": "rebote|反弹"},
    "mechanism_travel": {
        "en": r"(?:mech\w*|drive|rod)\W*(?:travel|stroke)",
        "de": "antriebs?(?:hub|weg)",
    },
    "wipe": {"en": r"\bwipe\b|penetration|contact engagement"},
    "damping_time": {"en": "damp"},
    "speed": {"en": r"veloc|speed|\bv\b", "de": "geschw", "fr": "vitesse", "zh": "速度"},
    "travel_time": {"en": r"(?:travel|stroke|running|motion)\W*time", "de": "laufzeit"},
    "closing_time": {
        "en": r"clos\w*\W*time",
        "de": r"einschalt\w*zeit",
        "fr zh": "temps de fermeture|合闸时间",
    },
    "opening_time": {
        "en": r"(?:open|trip)\w*\W*time",
        "de": r"ausschalt\w*zeit",
        "fr zh": "temps d.ouverture|分闸时间",
    },
    "stroke": {
        "en": "stroke|travel",
        "de": r"\bhub\b|\bweg\b|schalthub",
        "fr es": "course|carrera",
        "zh": "行程",
    },
}
"""What a name means that an analyser prints beside a result; by "" that it is of none."""

RESULT_HEADS = {
    "en": r"param|quantit|result|measur|value|name|descr|item|channel|phase|pole|^$",
    "de fr": "mess|größe|grandeur",
}
"""What stands above the names of results in a table of them."""

ONE_LETTER_SHORT = ("Serial", "Sampling", "Interval", "Station")
"""Words of names that exports have with a letter less."""

# ---- units --------------------------------------------------------------------------------------

UNITS = {
    "s": "s с sec secs second seconds sek sekunden сек segundos seconde secondes secondi 秒",
    "ms": "ms мс msec msecs msek millisec millisecs millisecond milliseconds millisekunden мсек "
    "milisegundos millisecondes millisecondi 毫秒",
    "us": "us мкс µs μs usec µsec μsec microsec microsecs microsecond microseconds",
    "mm": "mm мм millimeter millimeters millimetre millimetres milímetros milimetros millimètres "
    "millimetri миллиметр 毫米",
    "cm": "cm centimeter centimeters centimetre centimetres",
    "m": "m meter meters metre metres",
    "um": "um µm μm micron microns micrometer micrometers micrometre micrometres",
    "inch": "in inch inches zoll \" '' ″ pulgada pulgadas pulg pouce pouces pollice pollici "
    "polegada polegadas дюйм дюймы 英寸",
    "deg": "deg degs degree degrees ° º ˚ °deg grad grade grads winkelgrad grado grados gradi "
    "grau graus degré degrés degre degres graden grader stopnie град градус градусы 度",
    "rad": "rad rads radian radians",
    "V": "V volt volts",
    "counts": "count counts cts digit digits inc incs incr increment increments pulse pulses lsb",
    "%": "% pct percent prozent",
}
"""Spellings of the units of times and travels, each in its own case if it is a letter."""

OTHER_UNITS = (
    "ns min h dm km nm ft mil thou mrad gon A mA kA mV kV W N kN Pa bar Hz kHz кГц Ω ohm °C "
    "uOhm µOhm μOhm mOhm kOhm uΩ µΩ μΩ mΩ kΩ "
    "m/s mm/s mm/ms cm/s ft/s in/s deg/s rad/s m/s² m/s2 g"
)
"""Units of no time or travel that the settings can have: they contradict any of these."""

AMPERES = {"A": 1.0, "mA": 1e-3, "kA": 1e3}
"""Amperes that one of a unit of currents is."""

NO_UNITS = frozenset(["A", "V", "W", "N", "h", "g", "in", "inc"])
"""What behind a name rather is a phase, a pole or a direction than a unit."""

RATE_PREFIXES = {1.0: "k kilo к", 1e3: "m mega м"}
HERTZ = "hz|hertz|гц|sps|(?:s|sa|samples?|pts|points|1)/s(?:ec)?"
KILOCYCLES = "k(?:c|cs|cps|c/s)?"
PER_MS = "(?:s|sa|samples?|pts|points|1)?/ms"
"""Units of rates, in lower case and without blanks, and prefixes by the kHz of their hertz; a
kilocycle is one of a second, and so is a bare k."""

BEFORE_COLON = "[kmuкм]?(?:hz|гц|s|с)|[kc]c|%"
"""What between a comma and a colon rather is a unit than a name."""

BEHIND_NUMBER = "[kMG]?Hz|k?S?sps|[mk]V|[mk]A|[mcu]m|[mun]s|bar|degC|rpm"
"""Units behind a number in the name of a file, in their own case."""

SHARE_OF_STROKE = frozenset(["%", "percent", "% of stroke"])
"""Units of points of speeds that are a share of the stroke."""

# ---- dates --------------------------------------------------------------------------------------

MONTHS = {
    "en": "jan feb mar apr may jun jul aug sep oct nov dec",
    "de": "jan feb mär apr mai jun jul aug sep okt nov dez",
    "fr": "jan fév mar avr mai juin juil aoû sep oct nov déc",
}
"""Months, by the letters with which they begin."""

MONTH_ENDS = "uary?|vier|ruary?|rier|ch|z|s|il|[eiy]|ust|t|let|(?:t?em|o)(?:ber|bre)"
"""How names of months may go on."""
