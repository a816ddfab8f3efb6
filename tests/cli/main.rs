//! The command lines, each from its arguments to what it writes.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]

mod bad_input;
mod calib_beads;
mod calib_bodies;
mod calib_bone;
mod calib_camera;
mod calib_discs;
mod calib_exchange;
mod calib_grid;
mod calib_live;
mod calib_live_walk;
mod calib_mesh;
mod calib_pivot;
mod calib_register;
mod calib_sweep;
#[path = "check/doubts.rs"]
mod check_doubts;
#[path = "check/organs.rs"]
mod check_organs;
mod configs;
#[path = "localizer/decode.rs"]
mod decode;
#[path = "volume/derived.rs"]
mod derived;
mod help;
mod labels;
mod plan_labels;
mod plan_points;
mod receive;
mod simulate;
mod snapshot;
mod steps;
#[path = "study/program.rs"]
mod study;
#[path = "../support/mod.rs"]
mod support;
mod volume_tools;
#[path = "whole_way/walk.rs"]
mod whole_way;
