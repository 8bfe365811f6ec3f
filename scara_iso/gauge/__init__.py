"""Is the dial good enough: studies of a measuring system by AIAG's MSA manual and by VDA 5.

`read_gauge_tables` takes the tables of a study, `study_gauge` says which kind of study they are
and gives its figures, each with an interval, and what a tolerance makes of them.
"""

from typing import TYPE_CHECKING

from scara_iso.base.faces import face

if TYPE_CHECKING:
    from scara_iso.gauge.budget import Budget as Budget
    from scara_iso.gauge.crossed import Crossed as Crossed, whole_categories as whole_categories
    from scara_iso.gauge.reference_parts import (
        Linearity as Linearity,
        Stability as Stability,
        TypeOne as TypeOne,
    )
    from scara_iso.gauge.study import (
        AxisStudy as AxisStudy,
        Criterion as Criterion,
        GaugeStudy as GaugeStudy,
        study_gauge as study_gauge,
    )
    from scara_iso.gauge.table import Remark as Remark, read_gauge_tables as read_gauge_tables
else:
    __getattr__ = face(__name__)
