//! A table's CSV as typst, with heads in two rows where columns form groups.

/// `#word("name", columns: …, cells)`, to be followed by its caption.
pub(crate) fn typst_table(word: &str, name: &str, text: &str) -> Result<String, String> {
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(text.as_bytes());
    let rows: Vec<Vec<String>> = reader
        .records()
        .map(|row| row.map(|cells| cells.iter().map(str::to_owned).collect()))
        .collect::<Result<_, _>>()
        .map_err(|e| format!("table `{name}` is not CSV: {e}"))?;
    let Some((head, body)) = rows.split_first() else { return Err(format!("table `{name}` is empty")) };
    let cells: Vec<String> =
        body.iter().flatten().map(|cell| string_literal(if cell.is_empty() { "–" } else { cell })).collect();
    let numeric = |k: usize| {
        body.iter()
            .all(|row| row[k].is_empty() || row[k].starts_with(|c: char| c.is_ascii_digit() || "-−≤<".contains(c)))
    };
    let align: Vec<&str> = (0..head.len()).map(|k| if numeric(k) { "right" } else { "left" }).collect();
    Ok(format!(
        "#{word}(\"{name}\", ({}), ({},), ({},))",
        align.join(", ") + ",",
        head_cells(head).join(", "),
        cells.join(", ")
    ))
}

/// Text that typst prints verbatim.
pub(crate) fn string_literal(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

/// Head cells: `group: title (unit)` stands under its group, spanned over its columns; others span both rows.
fn head_cells(head: &[String]) -> Vec<String> {
    let split: Vec<(&str, &str)> = head.iter().map(|h| h.split_once(": ").unwrap_or(("", h))).collect();
    if split.iter().all(|(group, _)| group.is_empty()) {
        return head.iter().map(|h| string_literal(h)).collect();
    }
    let (mut upper, mut rules, mut lower, mut k) = (Vec::new(), Vec::new(), Vec::new(), 0);
    while k < split.len() {
        let (group, title) = split[k];
        let span = split[k..].iter().take_while(|(g, _)| *g == group && !group.is_empty()).count().max(1);
        if group.is_empty() {
            upper.push(format!("table.cell(rowspan: 2, align: bottom + left, strong({}))", string_literal(title)));
        } else {
            let unit = title.find('(').map_or("", |start| &title[start..]);
            let words = string_literal(format!("{group} {unit}").trim_end());
            upper.push(format!("table.cell(colspan: {span}, align: center, strong({words}))"));
            rules.push(format!("table.hline(y: 1, start: {k}, end: {}, stroke: 0.3pt)", k + span));
            lower.extend(split[k..k + span].iter().map(|(_, t)| string_literal(t.split(" (").next().unwrap_or(t))));
        }
        k += span;
    }
    [upper, rules, lower].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_has_a_head_over_columns_that_belong_together() {
        let made = typst_table("tabular", "t", "a,b: ours (s),b: published (s)\nx,1,\n\"y, \"\"z\"\"\",2,3\n").unwrap();
        assert!(made.contains("align: bottom + left, strong(\"a\"))"), "{made}");
        assert!(made.contains("table.cell(colspan: 2, align: center, strong(\"b (s)\"))"), "{made}");
        assert!(made.contains("start: 1, end: 3, stroke: 0.3pt), \"ours\", \"published\""), "{made}");
        assert!(
            made.contains("(left, right, right,)") && made.contains("\"x\", \"1\", \"–\", \"y, \\\"z\\\"\""),
            "{made}"
        );
    }

    #[test]
    fn a_row_of_another_length_is_refused() {
        assert!(typst_table("tabular", "t", "a,b\nx\n").is_err());
    }
}
