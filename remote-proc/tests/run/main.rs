//! Two runs of this machine, one shown in the other: real processes, a real bus each, a real link between them.

mod cuts;
mod pilot;
mod refused;
mod rig;
mod shown;
