//! A run of an encoder with swapped channels.

/// The run with negated counts and speeds.
pub fn reversed(text: &str) -> String {
    let mut names: Vec<&str> = Vec::new();
    let mut lines = Vec::new();
    for line in text.lines() {
        let cells: Vec<&str> = line.split(',').collect();
        if line.starts_with('#') || names.is_empty() {
            if !line.starts_with('#') {
                names = cells;
            }
            lines.push(line.to_owned());
            continue;
        }
        let turned = |(name, cell): (&&str, &str)| match (*name, cell.strip_prefix('-')) {
            ("counts" | "velocity_rad_s", Some(positive)) => positive.to_owned(),
            ("counts" | "velocity_rad_s", None) if !cell.is_empty() => format!("-{cell}"),
            _ => cell.to_owned(),
        };
        let turned: Vec<String> = names.iter().zip(cells).map(turned).collect();
        lines.push(turned.join(","));
    }
    lines.join("\n") + "\n"
}
