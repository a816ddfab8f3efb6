//! A start from nothing: the image's place as nine free numbers, which are linear.
//!
//! A pixel lies at `c_u u + c_v v + t` in the probe, whatever the two columns are; so the distance of a point from
//! its wire is linear in
//! the nine numbers, for wires in any arrangement, and the least squares need no start. Weights that begin convex
//! (graduated) let go of
//! points that belong to no wire. The two columns are then made square.

use fit::robust::{MEDIAN_CHI2_2, convex_widths, geman_mcclure, squared_scale};
use nalgebra::{SMatrix, SVector, Vector2, Vector3, Vector6};

use crate::error::ProbeError;
use crate::solve::{Data, MEDIAN_CHI2_1, Posed, State, Wall, unskewed};

type Matrix9 = SMatrix<f64, 9, 9>;
type Rows = SMatrix<f64, 2, 9>;

/// Unit of a pixel in the equations: numbers of all columns are then of one size.
const PIXELS: f64 = 300.0;

/// The start by wires.
pub(crate) fn by_wires(data: &Data<'_>) -> Result<State, ProbeError> {
    let rows = rows(data)?;
    let mut weights = vec![1.0; rows.len()];
    let mut found = solve(&rows, &weights)?;
    let squares = |x: &SVector<f64, 9>| -> Vec<f64> {
        let square = |(a, b): &(Rows, Vector2<f64>)| (a * x - b).norm_squared();
        rows.iter().map(square).collect()
    };
    let now = squares(&found);
    // A hundredth of a millimetre is what no localizer reaches: below it all points are right.
    let scale = squared_scale(&mut now.clone(), MEDIAN_CHI2_2, 1e-4);
    let largest = now.iter().fold(0.0, |a: f64, b| a.max(*b)) / scale;
    for width in convex_widths(largest).chain([1.0; 10]) {
        let now = squares(&found);
        let scale = squared_scale(&mut now.clone(), MEDIAN_CHI2_2, 1e-4);
        weights = now.iter().map(|s| geman_mcclure(width, s / scale)).collect();
        found = solve(&rows, &weights)?;
    }
    placed(data, &found)
}

/// The state that nine numbers mean.
fn placed(data: &Data<'_>, found: &SVector<f64, 9>) -> Result<State, ProbeError> {
    let column = |k: usize| -> Vector3<f64> { found.fixed_rows::<3>(3 * k).into_owned() };
    let (image, size) =
        unskewed(&(column(0) / PIXELS), &(column(1) / PIXELS), &column(2)).ok_or(ProbeError::Nowhere)?;
    Ok(State {
        image,
        size,
        phantom: Vector6::zeros(),
        lag: 0.0,
        tracker: nalgebra::Matrix3::zeros(),
        play: vec![[0.0; 4]; data.lines.len()],
        wall: Wall {
            normal: Vector3::z(),
            distance: 0.0,
        },
    })
}

fn rows(data: &Data<'_>) -> Result<Vec<(Rows, Vector2<f64>)>, ProbeError> {
    let poses = data.poses(0.0)?;
    let (given_turn, given_shift) = &data.phantom_from_reference;
    let mut rows = Vec::new();
    for (seen, pose) in data.frames.iter().zip(&poses.each) {
        for mark in &seen.marks {
            let line = &data.lines[mark.wire];
            let across = SMatrix::<f64, 2, 3>::from_rows(&[line.across[0].transpose(), line.across[1].transpose()]);
            let by = across * given_turn * pose.turn;
            let mut row = Rows::zeros();
            let scaled = [0, 1].map(|k| (mark.px[k] - data.middle[k]) / PIXELS);
            for (k, factor) in [scaled[0], scaled[1], 1.0].into_iter().enumerate() {
                row.fixed_view_mut::<2, 3>(0, 3 * k).copy_from(&(by * factor));
            }
            let right = across * (line.front - (given_turn * pose.shift + given_shift));
            rows.push((row, right));
        }
    }
    Ok(rows)
}

fn solve(rows: &[(Rows, Vector2<f64>)], weights: &[f64]) -> Result<SVector<f64, 9>, ProbeError> {
    let (mut normal, mut right) = (Matrix9::zeros(), SVector::<f64, 9>::zeros());
    for ((a, b), weight) in rows.iter().zip(weights) {
        normal += a.transpose() * a * *weight;
        right += a.transpose() * b * *weight;
    }
    // A motion that nothing holds is left where it is, not followed to infinity: the fit tells it with its deviation.
    let ridge = normal.trace() * 1e-12;
    (normal + Matrix9::identity() * ridge)
        .cholesky()
        .map(|solved| solved.solve(&right))
        .ok_or(ProbeError::Nowhere)
}

/// Starts by a wall whose place is not known: for each of many directions of its normal the ten numbers are linear,
/// and the best few
/// directions are followed further.
pub(crate) fn by_wall(data: &Data<'_>) -> Result<Vec<State>, ProbeError> {
    let poses = data.poses(0.0)?;
    let mut found: Vec<(f64, State)> = Vec::new();
    for k in 0..DIRECTIONS {
        let normal = direction(k);
        if let Some(next) = on_wall(data, &poses.each, &normal) {
            found.push(next);
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.truncate(FOLLOWED);
    if found.is_empty() {
        return Err(ProbeError::Nowhere);
    }
    Ok(found.into_iter().map(|(_, state)| state).collect())
}

/// Directions of half a sphere that are tried: they lie 15 degrees apart.
const DIRECTIONS: usize = 96;
/// Starts that are followed.
const FOLLOWED: usize = 6;

/// A point of the upper half sphere, all evenly spread (a spiral of golden angles).
fn direction(k: usize) -> Vector3<f64> {
    let z = (k as f64 + 0.5) / DIRECTIONS as f64;
    let (sin, cos) = (k as f64 * 2.399_963_229_728_653).sin_cos();
    let radius = (1.0 - z * z).sqrt();
    Vector3::new(radius * cos, radius * sin, z)
}

/// The image by a wall of this normal, and how far its points lie off, bounded; `None` where no image of two axes
/// comes out.
fn on_wall(data: &Data<'_>, poses: &[Posed], normal: &Vector3<f64>) -> Option<(f64, State)> {
    let mut rows = Vec::new();
    for (seen, pose) in data.frames.iter().zip(poses) {
        let by = pose.turn.transpose() * normal;
        for mark in &seen.marks {
            let mut row = SVector::<f64, 10>::zeros();
            let scaled = [0, 1].map(|k| (mark.px[k] - data.middle[k]) / PIXELS);
            for (k, factor) in [scaled[0], scaled[1], 1.0].into_iter().enumerate() {
                row.fixed_rows_mut::<3>(3 * k).copy_from(&(by * factor));
            }
            row[9] = -1.0;
            rows.push((row, -normal.dot(&pose.shift)));
        }
    }
    let mut found = SVector::<f64, 10>::zeros();
    let (mut cost, mut scale) = (f64::INFINITY, f64::INFINITY);
    // Weights by the residuals before: five rounds show which direction is right, and the fit does the rest.
    for round in 0..6 {
        let squares: Vec<f64> = rows.iter().map(|(a, b)| (a.dot(&found) - b).powi(2)).collect();
        scale = if round == 0 {
            f64::INFINITY
        } else {
            squared_scale(&mut squares.clone(), MEDIAN_CHI2_1, 1e-4)
        };
        let weight = |square: &f64| {
            if round == 0 {
                1.0
            } else {
                geman_mcclure(1.0, square / scale)
            }
        };
        let (mut normal, mut right) = (SMatrix::<f64, 10, 10>::zeros(), SVector::<f64, 10>::zeros());
        for ((a, b), square) in rows.iter().zip(&squares) {
            let weighted = a * weight(square);
            normal += weighted * a.transpose();
            right += weighted * *b;
        }
        let ridge = normal.trace() * 1e-10;
        found = (normal + SMatrix::<f64, 10, 10>::identity() * ridge)
            .cholesky()?
            .solve(&right);
        // In mm^2, up to 3 mm a point: directions are compared in one unit.
        let off = rows.iter().map(|(a, b)| (a.dot(&found) - b).powi(2));
        cost = off.map(|s| 9.0 * s / (9.0 + s)).sum();
    }
    let mut state = placed(data, &found.fixed_rows::<9>(0).into_owned()).ok()?;
    state.wall = Wall {
        normal: *normal,
        distance: found[9],
    };
    (cost.is_finite() && scale.is_finite()).then_some((cost, state))
}
