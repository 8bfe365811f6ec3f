"""The report on a result, decided once; `render` decides how it looks.

A report is sections of blocks: text, tables, strips and notices. A number keeps all
its digits and carries how many of them are worth showing; who shows it rounds.
"""

from typing import TYPE_CHECKING

from scara_iso.base.faces import face

if TYPE_CHECKING:
    from scara_iso.reporting.analysis import (
        after_analysis as after_analysis,
        analysis_report as analysis_report,
        axis_of_loop as axis_of_loop,
    )
    from scara_iso.reporting.backlash import (
        PublishedDemo as PublishedDemo,
        backlash_report as backlash_report,
        paper_section as paper_section,
        sweep_report as sweep_report,
    )
    from scara_iso.reporting.comparison import comparison_report as comparison_report
    from scara_iso.reporting.diagnosis import (
        diagnosis_report as diagnosis_report,
        poses_report as poses_report,
        summary_report as summary_report,
    )
    from scara_iso.reporting.dossier import (
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
    from scara_iso.reporting.explain import (
        PublishedPages as PublishedPages,
        find_pages as find_pages,
        list_report as list_report,
        pages as pages,
        pages_report as pages_report,
    )
    from scara_iso.reporting.fleet import (
        fleet_figures_report as fleet_figures_report,
        fleet_report as fleet_report,
    )
    from scara_iso.reporting.gauge_study import gauge_study_report as gauge_study_report
    from scara_iso.reporting.history import (
        history_document as history_document,
        history_report as history_report,
    )
    from scara_iso.reporting.languages import (
        ENGLISH as ENGLISH,
        known_languages as known_languages,
        labels_of as labels_of,
    )
    from scara_iso.reporting.named_effects import Failure as Failure, warning as warning
    from scara_iso.reporting.pictures import (
        comparison_pictures as comparison_pictures,
        diagnosis_pictures as diagnosis_pictures,
        study_picture as study_picture,
    )
    from scara_iso.reporting.plan import (
        design_of_poses_report as design_of_poses_report,
        design_report as design_report,
        missing_report as missing_report,
        plan_report as plan_report,
        separating_report as separating_report,
        status_report as status_report,
        visits_csv as visits_csv,
    )
    from scara_iso.reporting.report import document as document, readings_report as readings_report
    from scara_iso.reporting.shared.blocks import (
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
    from scara_iso.reporting.shared.digits import (
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
    from scara_iso.reporting.shared.limits import conformity as conformity
    from scara_iso.reporting.shared.stated import (
        FIELDS as FIELDS,
        left_unused as left_unused,
        not_stated as not_stated,
        stated_field as stated_field,
        table_report as table_report,
    )
    from scara_iso.reporting.signals import (
        push_report as push_report,
        visits_report as visits_report,
    )
    from scara_iso.reporting.validation import (
        Installation as Installation,
        ReferenceCheck as ReferenceCheck,
        Validation as Validation,
        validation_document as validation_document,
        validation_report as validation_report,
    )
else:
    __getattr__ = face(__name__)
