//! The `pilot` process.

use pilot::cli::Depth;

fn main() -> std::process::ExitCode {
    pilot::cli::main(pilot::cli::Hands {
        load: |spec, seed| {
            let (volume, told) = volume_loader::load_told_seeded(spec, seed)?;
            Ok((volume, told.warnings))
        },
        load_labels: volume_loader::load_labels_seeded,
        label_names: |path| Ok(volume_loader::label_names(path)?),
        organs: |scene, depth| {
            let reads: tissue_proc::check::Reads = (
                |spec, seed| Ok(*volume_loader::open(spec, seed)?.grid()),
                volume_loader::load_labels_seeded,
            );
            match depth {
                Depth::Text => tissue_proc::check::text(scene).map(|()| None),
                Depth::Map => tissue_proc::check::map(scene, reads).map(|()| None),
                Depth::Meshes => tissue_proc::check::meshes(scene, reads),
            }
        },
        tank: |scene| match tracker_proc::probe::Tank::of(scene) {
            Ok(_) | Err(tracker_proc::probe::TankError::Io { .. }) => Ok(()),
            Err(why) => Err(why.into()),
        },
        structure_set: |path, examination| {
            let set = volume_loader::structure_set(path, examination)?;
            Ok(set.map(|set| pilot::cli::StructureSet {
                points: set.points.into_iter().map(|point| (point.name, point.ct_mm)).collect(),
                others: set.others,
                is_in_its_frame: set.is_in_its_frame,
                warnings: set.warnings,
            }))
        },
        structure_set_bytes: |examination, points| {
            let named = |(name, ct_mm): &(String, [f64; 3])| volume_loader::NamedPoint {
                name: name.clone(),
                ct_mm: *ct_mm,
            };
            let points: Vec<_> = points.iter().map(named).collect();
            Ok(volume_loader::structure_set_bytes(examination, &points)?)
        },
    })
}
