mod bad;
mod claims;
mod exact;
mod fields;
mod pixels;
mod slices;
mod stage;
mod whole;
