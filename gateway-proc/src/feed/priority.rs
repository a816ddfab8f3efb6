//! Whether this thread comes before whatever has no real-time priority.

/// Where the policy stands behind the name in `/proc/PID/stat`: the 41st field, of which the first two are the number and the name.
const POLICY: usize = 41 - 3;

/// SCHED_FIFO or SCHED_RR, as somebody may have said of the process, also after it was started. Where the system does not tell: no.
pub(super) fn is_real_time() -> bool {
    std::fs::read_to_string("/proc/thread-self/stat").is_ok_and(|stat| is_real_time_by(&stat))
}

fn is_real_time_by(stat: &str) -> bool {
    // A name may have spaces and brackets.
    let fields = stat.rsplit_once(')').map_or("", |(_, fields)| fields);
    matches!(fields.split_whitespace().nth(POLICY), Some("1" | "2"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_policy_is_found_behind_any_name() {
        let stat = |policy: u32| format!("7 (a) b (c) S {}40 {policy} 0 0", "0 ".repeat(36));
        let found: Vec<bool> = (0..4).map(|policy| is_real_time_by(&stat(policy))).collect();
        assert_eq!(found, [false, true, true, false]);
        assert!(!is_real_time_by("") && !is_real_time_by("7 (a) S 0"));
        // That of this thread is there.
        let own = std::fs::read_to_string("/proc/thread-self/stat").unwrap();
        let (_, fields) = own.rsplit_once(')').unwrap();
        assert!(fields.split_whitespace().nth(POLICY).is_some());
    }
}
