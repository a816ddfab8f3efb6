//! The `pilot` process.

fn main() -> std::process::ExitCode {
    pilot::cli::main(pilot::cli::Hands {
        load: volume_loader::load_seeded,
        load_labels: volume_loader::load_labels_seeded,
        label_names: |path| Ok(volume_loader::label_names(path)?),
        structure_set: |path, examination| {
            let set = volume_loader::structure_set(path, examination)?;
            Ok(set.map(|set| pilot::cli::StructureSet {
                points: set.points.into_iter().map(|point| (point.name, point.ct_mm)).collect(),
                others: set.others,
                is_in_its_frame: set.is_in_its_frame,
            }))
        },
    })
}
