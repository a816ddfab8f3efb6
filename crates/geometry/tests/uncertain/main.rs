//! Transforms with covariance.

#![allow(clippy::unwrap_used, reason = "a test stops where it cannot go on")]

mod propagation;
mod properties;
mod support;
