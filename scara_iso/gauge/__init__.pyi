from .budget import Budget as Budget
from .crossed import Crossed as Crossed, whole_categories as whole_categories
from .reference_parts import (
    Linearity as Linearity,
    Stability as Stability,
    TypeOne as TypeOne,
)
from .study import (
    AxisStudy as AxisStudy,
    Criterion as Criterion,
    GaugeStudy as GaugeStudy,
    study_gauge as study_gauge,
)
from .table import Remark as Remark, read_gauge_tables as read_gauge_tables
