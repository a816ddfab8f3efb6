//! Contact with bone and of organs.

mod bone_of_label;
mod hertz;
pub(crate) mod obstacle;
pub(crate) mod organs;
mod shares;
mod stack;
