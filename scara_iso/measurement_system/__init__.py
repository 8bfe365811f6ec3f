"""Is the dial good enough: studies of a measuring system by AIAG's MSA manual and by VDA 5.

`read_gauge_tables` takes the tables of a study, `study_gauge` says which kind of study they are
and gives its figures, each with an interval, and what a tolerance makes of them.
"""

from typing import TYPE_CHECKING

from scara_iso.faces import face

if TYPE_CHECKING:
    from scara_iso.measurement_system.budget import Budget as Budget
    from scara_iso.measurement_system.criteria import Criterion as Criterion
    from scara_iso.measurement_system.crossed import (
        Component as Component,
        Crossed as Crossed,
    )
    from scara_iso.measurement_system.linearity import Linearity as Linearity
    from scara_iso.measurement_system.published import (
        PublishedGaugeStudy as PublishedGaugeStudy,
        published_gauge_study as published_gauge_study,
    )
    from scara_iso.measurement_system.ranges import (
        ByRanges as ByRanges,
        whole_categories as whole_categories,
    )
    from scara_iso.measurement_system.readings import (
        GaugeReadings as GaugeReadings,
        Remark as Remark,
    )
    from scara_iso.measurement_system.stability import Stability as Stability
    from scara_iso.measurement_system.study import (
        AxisStudy as AxisStudy,
        GaugeStudy as GaugeStudy,
        StudyKind as StudyKind,
        study_gauge as study_gauge,
    )
    from scara_iso.measurement_system.table import (
        GaugeTables as GaugeTables,
        read_gauge_tables as read_gauge_tables,
    )
    from scara_iso.measurement_system.type_1 import TypeOne as TypeOne
else:
    __getattr__ = face(__name__)
