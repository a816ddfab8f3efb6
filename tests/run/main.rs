//! Runs of real processes, and what happens when something breaks.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]

mod bad_pose;
#[path = "../support/display.rs"]
mod display;
mod foxglove;
mod guide;
mod identity;
mod injected_faults;
mod look;
mod notices;
mod operating_room;
mod other_user;
mod pipeline;
mod plan;
mod pose_stream;
mod recorder;
mod recorder_faults;
mod recorder_navigates;
mod recorder_rig;
mod recorder_session;
mod rejoin;
mod scene_topics;
mod simulated_time;
mod supervision;
#[path = "../support/mod.rs"]
mod support;
mod tissue;
mod tracker;
mod us_images;
mod window;
