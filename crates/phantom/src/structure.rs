//! Numbers of the patient's structures, those of TotalSegmentator's list of 117 (version 2), so that scenes made for its label maps
//! fit. Of the other structures there is no label.

/// The right kidney with its pelvis, but not its fat.
pub const KIDNEY_RIGHT: u16 = 2;
/// The left kidney.
pub const KIDNEY_LEFT: u16 = 3;
/// On the right: quadratus lumborum and the erectors of the spine (TotalSegmentator's autochthon), and psoas.
pub const MUSCLES_RIGHT: [u16; 2] = [87, 89];
/// The same on the left.
pub const MUSCLES_LEFT: [u16; 2] = [86, 88];
