//! Planning an operation: the plan's file, a run in which it is made on a screen, and what is said of it on the command
//! line.

mod desk;
mod follow;
mod points;
mod safety;
mod scene;
mod store;
mod text;

pub(crate) use desk::Desk;
pub(crate) use follow::{FollowError, follow};
pub(crate) use points::{DIAMETER_MM, PointsError, Taken, markups as points_of, take as take_points};
pub(crate) use safety::{LabelMap, Measured};
pub(crate) use scene::planning_scene;
pub(crate) use store::{PlanStore, StoreError};
pub(crate) use text::Findings;
