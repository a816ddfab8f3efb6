//! Where poses come from.

mod deceived;
mod emitters;
mod links;
mod localizer;
mod markers;
mod ndi;
mod ndi_cut;
mod ndi_deceived;
mod rate;
mod sequence;
