//! The page: every figure, table and claim, the stages with their times, and the inflated tail, in one file that needs no
//! network.

mod body;
mod live;

use std::fmt::Write;

use crate::claims;

pub use body::{Body, Surface};
pub use live::{LiveTail, LiveTrial};

/// A figure or table that is shown, or why it is not.
#[derive(Debug, Clone, PartialEq)]
pub struct Shown {
    /// Its name.
    pub name: String,
    /// Its caption.
    pub description: String,
    /// Its SVG or CSV; none where it was not made.
    pub text: Option<String>,
}

/// A claim with its verdict.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// What is claimed.
    pub says: String,
    /// Whether it reproduces.
    pub verdict: claims::Verdict,
    /// Its metric and rule.
    pub rule: String,
    /// The computed number.
    pub ours: String,
    /// The published value.
    pub published: String,
}

/// A stage and its computing time.
#[derive(Debug, Clone, PartialEq)]
pub struct Cost {
    /// Its name.
    pub name: String,
    /// Its description.
    pub description: String,
    /// Number of existing records, and of all.
    pub records: [usize; 2],
    /// Computing time, s.
    pub seconds: f64,
}

/// Everything on the page.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Page {
    /// Under the title.
    pub note: String,
    /// The tails in space.
    pub bodies: Vec<Body>,
    /// Those that move.
    pub tails: Vec<LiveTail>,
    /// SVG.
    pub figures: Vec<Shown>,
    /// CSV.
    pub tables: Vec<Shown>,
    /// In the order of `paper/claims.toml`.
    pub claims: Vec<Verdict>,
    /// The graph of the stages, as SVG.
    pub graph: Option<String>,
    /// In the order of the data.
    pub costs: Vec<Cost>,
}

/// Only content of the file itself may be loaded.
const POLICY: &str = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'";

impl Page {
    /// The page as HTML.
    pub fn html(&self) -> String {
        let parts = [
            self.inflated_tail(),
            live::live_section(&self.tails),
            self.all_figures(),
            self.all_tables(),
            self.all_claims(),
            self.all_stages(),
        ];
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" \
             content=\"width=device-width\">\n<meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n\
             <title>A paper that rebuilds itself</title>\n<style>\n{}</style>\n</head>\n<body>\n<header>\n\
             <h1>A paper that rebuilds itself</h1>\n<p>{}</p>\n</header>\n<nav>{NAVIGATION}</nav>\n{}\
             <script>\n{}</script>\n<script>\n{}{}</script>\n</body>\n</html>\n",
            include_str!("page.css"),
            escaped_html(&self.note),
            parts.concat(),
            include_str!("page.js"),
            twin::SCRIPT,
            include_str!("live.js"),
        )
    }

    fn inflated_tail(&self) -> String {
        let content = match self.bodies.is_empty() {
            true => "<p>No tail was inflated yet: <code>study run inflate</code>.</p>".into(),
            false => format!(
                "<canvas id=\"stage\" role=\"img\" aria-label=\"the inflated tail, turned by dragging\"></canvas>\n{PANEL}"
            ),
        };
        let bodies: Vec<String> = self.bodies.iter().map(Body::json).collect();
        // `<` is escaped, so that no text can end the script
        let data = format!("[{}]", bodies.join(",")).replace('<', "\\u003c");
        html_section("tail", "The inflated tail", &content)
            + &format!("<script type=\"application/json\" id=\"bodies\">{data}</script>\n")
    }

    fn all_figures(&self) -> String {
        let figure = |shown: &Shown| {
            let picture = shown.text.as_deref().map_or_else(absent_note, inline_svg);
            format!(
                "<figure id=\"figure-{0}\">\n{picture}<figcaption><b>{0}</b>: {1}</figcaption>\n</figure>\n",
                shown.name,
                escaped_html(&shown.description)
            )
        };
        html_section("figures", "Figures", &self.figures.iter().map(figure).collect::<String>())
    }

    fn all_tables(&self) -> String {
        let titled_table = |shown: &Shown| {
            let rows = shown.text.as_deref().map_or_else(absent_note, html_table);
            let (name, story) = (&shown.name, escaped_html(&shown.description));
            format!("<div id=\"table-{name}\">\n<h3>{name}</h3>\n<p class=\"story\">{story}</p>\n{rows}</div>\n")
        };
        html_section("tables", "Tables", &self.tables.iter().map(titled_table).collect::<String>())
    }

    fn all_claims(&self) -> String {
        let claim_row = |claim: &Verdict| {
            let (class, word) = match claim.verdict {
                claims::Verdict::Reproduces => ("reproduces", "reproduces"),
                claims::Verdict::Fails => ("fails", "does not reproduce"),
                claims::Verdict::NotMeasured => ("open", "open"),
                claims::Verdict::Undetermined => ("open", "not determined"),
                claims::Verdict::SetByBench => ("open", "set by the bench"),
                claims::Verdict::FailsByBench => ("fails", "does not reproduce (by the bench)"),
            };
            let cells = [&claim.says, &claim.ours, &claim.rule, &claim.published].map(|text| escaped_html(text));
            format!(
                "<tr><td class=\"verdict {class}\">{word}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
                cells[0], cells[1], cells[2], cells[3]
            )
        };
        let head = ["verdict", "claim", "ours", "rule", "published"].map(|h| format!("<th>{h}</th>")).concat();
        let rows: String = self.claims.iter().map(claim_row).collect();
        html_section(
            "claims",
            "Claims",
            &format!(
                "<div class=\"wide\"><table><thead><tr>{head}</tr></thead>\n<tbody>\n{rows}</tbody></table></div>\n"
            ),
        )
    }

    fn all_stages(&self) -> String {
        let longest = self.costs.iter().map(|c| c.seconds).fold(f64::MIN_POSITIVE, f64::max);
        let stage_row = |cost: &Cost| {
            format!(
                "<tr id=\"stage-{}\"><td>{0}</td><td>{}</td><td>{} of {}</td><td>{:.1}</td><td><span class=\"bar\" \
                 style=\"width:{:.2}rem\"></span></td></tr>\n",
                cost.name,
                escaped_html(&cost.description),
                cost.records[0],
                cost.records[1],
                cost.seconds,
                12.0 * cost.seconds / longest
            )
        };
        let head = ["stage", "description", "records", "seconds", ""].map(|h| format!("<th>{h}</th>")).concat();
        let rows: String = self.costs.iter().map(stage_row).collect();
        let graph =
            self.graph.as_deref().map_or_else(String::new, |svg| format!("<figure>\n{}</figure>\n", inline_svg(svg)));
        html_section(
            "stages",
            "Stages",
            &format!(
                "{graph}<div class=\"wide\"><table><thead><tr>{head}</tr></thead>\n<tbody>\n{rows}</tbody></table></div>\n"
            ),
        )
    }
}

const NAVIGATION: &str = "<a href=\"#tail\">Tail</a><a href=\"#live\">Live</a><a href=\"#figures\">Figures</a><a href=\"#tables\">Tables</a>\
                          <a href=\"#claims\">Claims</a><a href=\"#stages\">Stages</a>";
const PANEL: &str = "<div id=\"panel\"><select id=\"body\" aria-label=\"specimen\"></select><button id=\"play\">play</button>\
<input type=\"range\" id=\"level\" min=\"0\" max=\"1\" step=\"0.01\" value=\"0\" aria-label=\"pressure\"><output id=\"pressure\">\
</output><label><input type=\"checkbox\" id=\"cut\"> cut open</label><label><input type=\"checkbox\" id=\"far\"> colour by \
displacement</label></div>\n<p class=\"story\">Drag to turn it, roll to come nearer. Each shape is an equilibrium of the \
identified model; between two of them points run straight.</p>\n";

fn html_section(id: &str, title: &str, content: &str) -> String {
    format!("<section id=\"{id}\">\n<h2>{title}</h2>\n{content}</section>\n")
}

fn absent_note() -> String {
    "<p class=\"open\">It was not made in the last run.</p>\n".into()
}

/// An SVG for use inside HTML, without its XML declaration.
fn inline_svg(svg: &str) -> String {
    let namespaces = ["xmlns=\"http://www.w3.org/2000/svg\" ", "xmlns:xlink=\"http://www.w3.org/1999/xlink\" "];
    let plain = namespaces.iter().fold(svg.to_owned(), |text, name| text.replacen(name, "", 1));
    plain.replace("xlink:href=", "href=")
}

/// CSV as a table; its first line is the head.
fn html_table(csv: &str) -> String {
    let mut html = String::from("<div class=\"wide\"><table>\n");
    for (i, line) in csv.lines().enumerate() {
        let (tag, open, close) = match i {
            0 => ("th", "<thead>", "</thead>\n<tbody>"),
            _ => ("td", "", ""),
        };
        let cells: String = csv_cells(line).iter().map(|c| format!("<{tag}>{}</{tag}>", escaped_html(c))).collect();
        // writing into a string cannot fail
        let _ = writeln!(html, "{open}<tr>{cells}</tr>{close}");
    }
    html + "</tbody></table></div>\n"
}

/// The cells of a line of CSV, unquoted.
fn csv_cells(line: &str) -> Vec<String> {
    let (mut cells, mut quoted) = (vec![String::new()], false);
    let mut letters = line.chars().peekable();
    while let Some(letter) = letters.next() {
        match letter {
            '"' if quoted && letters.peek() == Some(&'"') => {
                letters.next();
                cells.last_mut().into_iter().for_each(|cell| cell.push('"'));
            }
            '"' => quoted = !quoted,
            ',' if !quoted => cells.push(String::new()),
            other => cells.last_mut().into_iter().for_each(|cell| cell.push(other)),
        }
    }
    cells
}

fn escaped_html(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn page() -> Page {
        let shown =
            |name: &str, text: &str| Shown { name: name.into(), description: "a < b".into(), text: Some(text.into()) };
        let svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" \
                   width=\"1mm\"><image xlink:href=\"data:image/png;base64,AA==\"/></svg>";
        let verdict = |verdict| Verdict {
            says: "theory over-predicts".into(),
            verdict,
            rule: "a ≥ 1".into(),
            ours: "2".into(),
            published: "yes".into(),
        };
        Page {
            note: "virtual".into(),
            figures: vec![shown("tail", svg)],
            tables: vec![shown("trials", "a,\"b, \"\"c\"\"\"\n1,2\n"), Shown { text: None, ..shown("methods", "") }],
            claims: vec![
                verdict(claims::Verdict::Reproduces),
                verdict(claims::Verdict::Fails),
                verdict(claims::Verdict::NotMeasured),
                verdict(claims::Verdict::SetByBench),
            ],
            costs: vec![Cost { name: "mesh".into(), description: "s".into(), records: [1, 1], seconds: 2.0 }],
            ..Page::default()
        }
    }

    #[test]
    fn no_address_leaves_the_page() {
        let html = page().html();
        assert!(!html.contains("http:") && !html.contains("https:") && !html.contains("url("), "{html}");
        let values = html.split(['=']).zip(html.split(['=']).skip(1));
        for (name, value) in values.filter(|(name, _)| name.ends_with("href") || name.ends_with("src")) {
            assert!(
                value.starts_with("\"#") || value.starts_with("\"data:"),
                "{name}={}",
                &value[..30.min(value.len())]
            );
        }
    }

    #[test]
    fn a_cell_with_a_comma_and_quotes_stays_one_cell() {
        assert_eq!(csv_cells("a,\"b, \"\"c\"\"\",d"), ["a", "b, \"c\"", "d"]);
    }

    #[test]
    fn each_verdict_has_its_own_word_and_what_was_not_made_is_said() {
        let html = page().html();
        for word in [">reproduces<", ">does not reproduce<", ">open<", ">set by the bench<", "It was not made"] {
            assert_eq!(html.matches(word).count(), 1, "{word}");
        }
    }

    #[test]
    fn words_of_records_cannot_become_tags() {
        assert!(page().html().contains("a &lt; b"));
    }
}
