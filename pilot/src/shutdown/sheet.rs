//! The contact sheet: all images of one pose on one picture, with a legend that says what they rest on.

use bus::message::{FrameStamp, ToolPose, Tracked};
use geometry::{Point, Tool};
use picture::palette::{self, ALARM, QUIET, WORDS};
use picture::{Anchor, Canvas, Rgb};
use scene::{Extent, Scene};

const GAP: u32 = 6;
const COLUMNS: usize = 4;
/// A line of the legend: text, colour, size.
type Words = (String, Rgb, f32);

/// One image for the sheet: pixels with their stamp, or `None` where a view has nothing to show.
pub(crate) struct Panel {
    pub(crate) image: Option<(Canvas, FrameStamp)>,
}

/// Global images in the first rows, local ones below them, at most four in a row.
fn rows(scene: &Scene) -> Vec<Vec<usize>> {
    let of = |extent| {
        let indices: Vec<usize> = (0..scene.views.len())
            .filter(|&i| scene.views[i].extent == extent)
            .collect();
        indices.chunks(COLUMNS).map(<[usize]>::to_vec).collect::<Vec<_>>()
    };
    [of(Extent::Global), of(Extent::Local)].concat()
}

/// Draws the sheet; `panels` in the order of the scene's views, `pose` the one that all of them show, `caption` what must be said
/// besides, in a colour of [`palette`].
pub(crate) fn draw(scene: &Scene, panels: &[Panel], pose: Option<&ToolPose>, caption: Option<(String, Rgb)>) -> Canvas {
    let rows = rows(scene);
    let cell = |axis: usize| scene.views.iter().map(|v| v.size[axis]).max().unwrap_or(1) + GAP;
    let columns = rows.iter().map(Vec::len).max().unwrap_or(1);
    // The legend stands in the first cell that is free, or in a column of its own.
    let free = rows.iter().position(|row| row.len() < columns);
    let width = cell(0) * (columns as u32 + u32::from(free.is_none())) + GAP;
    let mut canvas = Canvas::new(width, cell(1) * rows.len() as u32 + GAP);
    for (r, row) in rows.iter().enumerate() {
        for (c, &view) in row.iter().enumerate() {
            let at = [GAP + cell(0) * c as u32, GAP + cell(1) * r as u32];
            draw_panel(&mut canvas, scene, view, &panels[view], at);
        }
    }
    let (row, column) = free.map_or((0, columns), |r| (r, rows[r].len()));
    let at = [GAP + cell(0) * column as u32, GAP + cell(1) * row as u32];
    let mut lines = vec![("TROCAR".to_owned(), WORDS, 26.0)];
    lines.push(("not a medical device".to_owned(), QUIET, 15.0));
    lines.extend(caption.map(|(words, colour)| (words, colour, 18.0)));
    legend_lines(&mut lines, scene, panels, pose);
    legend(&mut canvas, scene, lines, at);
    canvas
}

fn draw_panel(canvas: &mut Canvas, scene: &Scene, view: usize, panel: &Panel, [x, y]: [u32; 2]) {
    if let Some((image, _)) = &panel.image {
        canvas.paste(image.rgba(), image.width(), x, y);
        return;
    }
    let view = &scene.views[view];
    let [w, h] = view.size.map(f64::from);
    let (x, y) = (f64::from(x), f64::from(y));
    canvas.fill([x, y], [w, h], Rgb(60, 0, 0), 255);
    let middle = [x + w / 2.0, y + h / 2.0];
    canvas.text(middle, &format!("{}: NOT LIVE", view.name), 22.0, ALARM, Anchor::Centre);
}

/// Only what is the same whenever the same pose is drawn again.
fn legend_lines(lines: &mut Vec<Words>, scene: &Scene, panels: &[Panel], pose: Option<&ToolPose>) {
    match pose {
        Some(pose) => {
            lines.extend(pose_lines(scene, pose));
            lines.push(set_line(panels));
        }
        None => lines.push(("NO POSE".to_owned(), ALARM, 20.0)),
    }
    if let Some((_, stamp)) = panels.iter().find_map(|p| p.image.as_ref()) {
        lines.push((format!("volume {}", &stamp.volume().to_string()[..16]), QUIET, 15.0));
        lines.push((format!("registration {:016x}", stamp.registration_id), QUIET, 15.0));
    }
}

/// Whether all images are there and show one pose: otherwise they must not be read side by side.
fn set_line(panels: &[Panel]) -> Words {
    let mut poses: Vec<u64> = panels
        .iter()
        .flat_map(|p| &p.image)
        .map(|(_, stamp)| stamp.seq)
        .collect();
    let (there, all) = (poses.len(), panels.len());
    poses.sort_unstable();
    match (poses.first(), poses.last()) {
        (Some(first), Some(last)) if first < last => (format!("IMAGES DIFFER: poses {first} to {last}"), ALARM, 18.0),
        (Some(pose), _) if there == all => (format!("all {all} images show pose {pose}"), QUIET, 15.0),
        (Some(pose), _) => (format!("{there} OF {all} IMAGES, all of pose {pose}"), ALARM, 18.0),
        (None, _) => ("NO IMAGE".to_owned(), ALARM, 18.0),
    }
}

fn legend(canvas: &mut Canvas, scene: &Scene, lines: Vec<Words>, [x, y]: [u32; 2]) {
    // Sizes are meant for cells of 512 pixels.
    let widest = scene.views.iter().map(|v| v.size[0]).max().unwrap_or(512);
    let unit = f64::from(widest) / 512.0;
    let mut at = f64::from(y) + 40.0 * unit;
    for (text, colour, size) in lines {
        let size = f64::from(size) * unit;
        canvas.text(
            [f64::from(x) + 24.0 * unit, at],
            &text,
            size as f32,
            colour,
            Anchor::Left,
        );
        at += size + 14.0 * unit;
    }
}

fn pose_lines(scene: &Scene, pose: &ToolPose) -> Vec<Words> {
    let mut lines = vec![(
        format!("pose {}  at {:.3} s", pose.seq, pose.t_device_ns as f64 / 1e9),
        WORDS,
        18.0,
    )];
    let Ok(Tracked::Valid(ct_from_tool)) = pose.tracked() else {
        return lines;
    };
    let tip = ct_from_tool * Point::<Tool>::new(0.0, 0.0, 0.0);
    lines.push((format!("tip {}", tip.in_words(1)), WORDS, 18.0));
    let mut targets: Vec<_> = scene
        .targets
        .iter()
        .map(|t| (t.centre.distance(tip), &t.name))
        .collect();
    targets.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (mm, name) in targets.into_iter().take(5) {
        lines.push((format!("{name}  {mm:.1} mm"), palette::TARGET, 16.0));
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn seven_images_make_two_rows_of_four_cells() {
        let scene = Scene::parse("", Path::new("")).unwrap();
        assert_eq!(rows(&scene), [vec![0, 2, 4], vec![1, 3, 5, 6]]);
        let panels: Vec<Panel> = (0..7).map(|_| Panel { image: None }).collect();
        let sheet = draw(&scene, &panels, None, Some(("REPLAY".to_owned(), palette::REPLAY)));
        assert_eq!((sheet.width(), sheet.height()), (4 * 518 + 6, 2 * 518 + 6));
    }

    #[test]
    fn the_sheet_says_whether_its_images_show_one_pose() {
        let panel = |seq| Panel {
            image: Some((
                Canvas::new(1, 1),
                FrameStamp {
                    seq,
                    ..FrameStamp::default()
                },
            )),
        };
        let none = Panel { image: None };
        assert_eq!(set_line(&[panel(7), panel(7)]).0, "all 2 images show pose 7");
        assert_eq!(set_line(&[panel(7), panel(9), none]).0, "IMAGES DIFFER: poses 7 to 9");
        assert_eq!(
            set_line(&[panel(7), Panel { image: None }]).0,
            "1 OF 2 IMAGES, all of pose 7"
        );
        assert_eq!(set_line(&[]).0, "NO IMAGE");
    }
}
