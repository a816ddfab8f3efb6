//! What the benchmarks of the reslice engine share: clocks, statistics, the volume of a usual CT, planes by chance.

pub(crate) mod ct;
pub(crate) mod figures;
pub(crate) mod planes;
