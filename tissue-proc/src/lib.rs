//! Floor 3: moves organs with the tracked tube. Of the newest pose it publishes where a model has the organs, with what certifies that; it
//! holds up nobody, and where it is late, refuses or dies, images show the examination as it was taken and say so.
//!
//! * `anatomy` reads the scene of organs and its label map, which must be on the voxels of the examination, and makes meshes.
//! * `live` answers a pose: at rest where the tube touches nothing, else the next state from the last; refused where nobody saw how the tube
//!   came there.
//! * [`offline`] has the same answers for poses of no run, and the same organs with other numbers.
//! * [`check`] is what it refuses at its start, without a run; `work` gives signs of life beside work of seconds.
//! * `message` puts meshes and states into messages, `run` is the process.

mod anatomy;
pub mod check;
pub mod cli;
mod errors;
mod live;
mod message;
pub mod offline;
mod run;
#[cfg(test)]
mod tests;
mod work;
