//! The summary as a report to read.

use std::fmt::{self, Display, Write};

use super::{Handedness, Summary};

impl Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.format)?;
        self.write_place(f)?;
        self.write_values(f)?;
        line(f, "volume hash", &self.hash)?;
        for (name, value) in &self.extra {
            line(f, name, value)?;
        }
        f.write_char('\n')?;
        for sketched in self.histogram.sketch() {
            writeln!(f, "  {}", sketched.trim_end())?;
        }
        writeln!(
            f,
            "  bins of {} HU, heights as logarithms; {} voxels below and {} above",
            self.histogram.width_hu, self.histogram.below, self.histogram.above
        )?;
        self.warnings
            .iter()
            .try_for_each(|warning| writeln!(f, "warning: {warning}"))
    }
}

impl Summary {
    fn write_place(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place = &self.place;
        let [nx, ny, nz] = place.dims;
        line(f, "voxels", format_args!("{nx} x {ny} x {nz} = {}", self.voxels))?;
        let [x, y, z] = place.spacing_mm;
        line(f, "spacing", format_args!("{x:.6} x {y:.6} x {z:.6} mm"))?;
        let [x, y, z] = place.size_mm;
        line(f, "size", format_args!("{x:.2} x {y:.2} x {z:.2} mm"))?;
        let (letters, words) = (&place.letters, &place.orientation);
        line(f, "orientation", format_args!("{letters}: {words}"))?;
        let [x, y, z] = place.off_axis_degrees;
        line(f, "off the axes", format_args!("{x:.3}, {y:.3}, {z:.3} degrees"))?;
        let handedness = match place.handedness {
            Handedness::RightHanded => "right-handed",
            Handedness::LeftHanded => "left-handed",
        };
        line(f, "axes", handedness)?;
        line(f, "tilt", format_args!("{:.4} degrees", place.tilt_degrees))?;
        for (name, [a, b, c, d]) in ["ct_from_voxel", "(LPS, mm)", ""].into_iter().zip(place.ct_from_voxel) {
            line(f, name, format_args!("{a:12.6} {b:12.6} {c:12.6} {d:14.6}"))?;
        }
        Ok(())
    }

    fn write_values(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(hu) = &self.hu {
            line(f, "HU", format_args!("{} to {}, mean {:.2}", hu.min, hu.max, hu.mean))?;
            let parts: Vec<String> = hu
                .percentiles
                .iter()
                .map(|(part, hu)| format!("{part} %: {hu}"))
                .collect();
            line(f, "percentiles", parts.join(", "))?;
        }
        let padding = &self.padding;
        let (hu, percent) = (padding.hu, 100.0 * padding.share);
        let told = match padding.told_from_air {
            true => "left out of the numbers",
            false => "not told from air, and counted",
        };
        line(
            f,
            "padding",
            format_args!("{hu} HU, {percent:.2} % of the voxels, {told}"),
        )?;
        if !self.marks.is_empty() {
            line(f, "marks", &self.marks)?;
        }
        Ok(())
    }
}

fn line(f: &mut fmt::Formatter<'_>, name: &str, value: impl Display) -> fmt::Result {
    writeln!(f, "  {name:<14} {value}")
}
