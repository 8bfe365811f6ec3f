from .analysis import (
    after_analysis as after_analysis,
    analysis_report as analysis_report,
    axis_of_loop as axis_of_loop,
)
from .backlash import (
    PublishedDemo as PublishedDemo,
    backlash_report as backlash_report,
    paper_section as paper_section,
    sweep_report as sweep_report,
)
from .comparison import comparison_report as comparison_report
from .diagnosis import (
    diagnosis_report as diagnosis_report,
    poses_report as poses_report,
    summary_report as summary_report,
)
from .dossier import (
    Amendment as Amendment,
    ConditionResults as ConditionResults,
    Dossier as Dossier,
    InputFile as InputFile,
    OfTable as OfTable,
    Provenance as Provenance,
    Restated as Restated,
    ResultsAndOtherTests as ResultsAndOtherTests,
    joined_dossier as joined_dossier,
    published_conditions as published_conditions,
    published_folder as published_folder,
)
from .explain import (
    PublishedPages as PublishedPages,
    find_pages as find_pages,
    list_report as list_report,
    pages as pages,
    pages_report as pages_report,
)
from .fleet import (
    fleet_figures_report as fleet_figures_report,
    fleet_report as fleet_report,
)
from .gauge_study import gauge_study_report as gauge_study_report
from .history import (
    history_document as history_document,
    history_report as history_report,
)
from .languages import (
    ENGLISH as ENGLISH,
    known_languages as known_languages,
    labels_of as labels_of,
)
from .named_effects import Failure as Failure, warning as warning
from .pictures import (
    comparison_pictures as comparison_pictures,
    diagnosis_pictures as diagnosis_pictures,
    study_picture as study_picture,
)
from .plan import (
    design_of_poses_report as design_of_poses_report,
    design_report as design_report,
    missing_report as missing_report,
    plan_report as plan_report,
    separating_report as separating_report,
    status_report as status_report,
    visits_csv as visits_csv,
)
from .report import document as document, readings_report as readings_report
from .shared.blocks import (
    Block as Block,
    Curve as Curve,
    Document as Document,
    Facts as Facts,
    Figure as Figure,
    NextStep as NextStep,
    Notice as Notice,
    Panel as Panel,
    Report as Report,
    Section as Section,
    Signature as Signature,
    Strip as Strip,
    Table as Table,
    Text as Text,
    in_form as in_form,
)
from .shared.digits import (
    LEVELS as LEVELS,
    Cell as Cell,
    Interval as Interval,
    Number as Number,
    Result as Result,
    U_of_scatter as U_of_scatter,
    printable as printable,
    rounded as rounded,
    sparkline as sparkline,
)
from .shared.limits import conformity as conformity
from .shared.stated import (
    FIELDS as FIELDS,
    left_unused as left_unused,
    not_stated as not_stated,
    stated_field as stated_field,
    table_report as table_report,
)
from .signals import (
    push_report as push_report,
    visits_report as visits_report,
)
from .validation import (
    Installation as Installation,
    ReferenceCheck as ReferenceCheck,
    Validation as Validation,
    validation_document as validation_document,
    validation_report as validation_report,
)
