//! Where a person looks on the planning screen, kept in a file of the run: a window that comes back looks there.

use std::fs;
use std::path::{Path, PathBuf};

use geometry::{Point, VolumeGrid};
use serde::{Deserialize, Serialize};

use super::camera::Cut;
use super::desk::Desk;

/// What is kept of it while the window is away.
#[derive(Debug, Serialize, Deserialize)]
struct Kept {
    /// When the run began: a look of another run is of another plan.
    epoch_ns: i64,
    cursor_ct_mm: [f64; 3],
    centre_hu: f64,
    width_hu: f64,
    selected: Option<String>,
    enlarged: Option<Cut>,
}

fn path(run_dir: &Path) -> PathBuf {
    run_dir.join("planning.look")
}

impl Desk {
    /// What was kept of a window that has gone; that of a new one where nothing was, or nothing that is of use.
    pub(crate) fn restored((run_dir, epoch_ns): (&Path, i64), grid: &VolumeGrid) -> Self {
        let mut desk = Self::new(grid);
        let text = scene::file::read_text(&path(run_dir), 4096).unwrap_or_default();
        let Ok(kept) = serde_json::from_str::<Kept>(&text) else {
            return desk;
        };
        if kept.epoch_ns != epoch_ns {
            return desk;
        }
        let [x, y, z] = kept.cursor_ct_mm;
        let cursor = Point::new(x, y, z);
        if grid.holds(cursor) && kept.centre_hu.is_finite() && kept.width_hu.is_finite() {
            desk.camera.look_at(cursor);
            let window = desk.camera.window;
            desk.camera
                .level(kept.width_hu - window.width_hu, kept.centre_hu - window.centre_hu);
        }
        (desk.selected, desk.enlarged) = (kept.selected, kept.enlarged);
        desk
    }

    /// Keeps it, whole or not at all.
    pub(crate) fn keep(&self, (run_dir, epoch_ns): (&Path, i64)) -> std::io::Result<()> {
        let kept = Kept {
            epoch_ns,
            cursor_ct_mm: self.camera.cursor.mm(),
            centre_hu: self.camera.window.centre_hu,
            width_hu: self.camera.window.width_hu,
            selected: self.selected.clone(),
            enlarged: self.enlarged,
        };
        let aside = path(run_dir).with_extension("look.new");
        fs::write(&aside, serde_json::to_string(&kept)?)?;
        fs::rename(&aside, path(run_dir))
    }
}

#[cfg(test)]
mod tests {
    use super::super::camera::Camera;
    use super::*;
    use geometry::Affine;

    fn grid() -> VolumeGrid {
        let rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        VolumeGrid::checked([100; 3], Affine::from_rows(rows)).unwrap()
    }

    #[test]
    fn a_window_that_comes_back_looks_where_it_looked() {
        let tmp = tempfile::tempdir().unwrap();
        let mut desk = Desk::new(&grid());
        desk.camera.look_at(Point::new(3.0, 4.0, 5.0));
        desk.camera.level(100.0, 20.0);
        (desk.selected, desk.enlarged) = (Some("node".to_owned()), Some(Cut::Sagittal));
        desk.keep((tmp.path(), 7)).unwrap();
        let back = Desk::restored((tmp.path(), 7), &grid());
        assert_eq!(
            (back.camera.cursor, back.camera.window),
            (desk.camera.cursor, desk.camera.window)
        );
        assert_eq!((back.selected, back.enlarged), (desk.selected, desk.enlarged));
        // Of a run of the same name that has ended.
        let new = Desk::restored((tmp.path(), 8), &grid());
        assert_eq!((new.camera, new.selected), (Camera::home(&grid()), None));
        // Of another examination, or no look at all.
        for bad in [
            "{\"epoch_ns\":7,\"cursor_ct_mm\":[1e9,0,0],\"centre_hu\":0,\"width_hu\":1,\"selected\":null,\"enlarged\":null}",
            "x",
        ] {
            fs::write(path(tmp.path()), bad).unwrap();
            assert_eq!(Desk::restored((tmp.path(), 7), &grid()).camera, Camera::home(&grid()));
        }
    }
}
