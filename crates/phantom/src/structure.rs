//! Numbers of the patient's structures, those of TotalSegmentator's list of 117 (version 2), so that scenes made for its label maps
//! fit; lymph nodes, which that list does not have, have numbers beyond it. Of the other structures there is no label.

/// The right kidney with its pelvis, but not its fat.
pub const KIDNEY_RIGHT: u16 = 2;
/// The left kidney.
pub const KIDNEY_LEFT: u16 = 3;
/// On the right: quadratus lumborum and the erectors of the spine (TotalSegmentator's autochthon), and psoas.
pub const MUSCLES_RIGHT: [u16; 2] = [87, 89];
/// The same on the left.
pub const MUSCLES_LEFT: [u16; 2] = [86, 88];
/// The aorta, above its bifurcation.
pub const AORTA: u16 = 52;
/// The inferior vena cava.
pub const VENA_CAVA: u16 = 63;
/// The iliac arteries, the left one first, with the first part of the inner ones.
pub const ILIAC_ARTERIES: [u16; 2] = [65, 66];
/// The iliac veins, the left one first.
pub const ILIAC_VEINS: [u16; 2] = [67, 68];
/// The five lymph nodes in the order of [`crate::Phantom::targets`], each a number of its own: a label is one solid.
pub const NODES: [u16; 5] = [201, 202, 203, 204, 205];
