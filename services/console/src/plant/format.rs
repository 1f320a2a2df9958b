//! `obsid plant format`: the definition of plant files, as text and as a page.

use crate::Failure;
use crate::recordings::tool;
use report::{Block, Cell, Page, Section, Table};
use std::path::PathBuf;

/// Print the definition of plant files: every key with its unit, default and meaning
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid plant format | less
  obsid plant format --html format.html    the same as one page")]
pub struct Arguments {
    /// Write a page to this file instead
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
}

/// # Errors
/// [`Failure::Run`] when the page cannot be written.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Some(path) = &arguments.html else {
        crate::print(plant_file::FORMAT);
        return Ok(());
    };
    std::fs::write(path, page(plant_file::FORMAT).html())
        .map_err(|error| Failure::Run(format!("{}: the page cannot be written: {error}", path.display())))?;
    crate::print(&format!("{}\n", path.display()));
    Ok(())
}

/// The page of a definition in Markdown: headings, paragraphs, lists, tables and blocks of code.
fn page(markdown: &str) -> Page {
    let mut sections = vec![Section::new("Numbers, vectors and names", Vec::new())];
    let mut lines = markdown.lines().peekable();
    while let Some(line) = lines.next() {
        if let Some(title) = line.strip_prefix("## ") {
            sections.push(Section::new(title, Vec::new()));
            continue;
        }
        let mut rest = |first: &str, goes_on: &dyn Fn(&str) -> bool| -> Vec<String> {
            let mut taken = vec![first.to_owned()];
            while let Some(next) = lines.next_if(|next| goes_on(next)) {
                taken.push(next.to_owned());
            }
            taken
        };
        let is_plain = |next: &str| !next.is_empty() && !next.starts_with("- ");
        let block = match line.as_bytes() {
            [] | [b'#', ..] => continue,
            [b'`', b'`', b'`', ..] => {
                let code = rest("", &|next| next != "```")[1..].join("\n");
                lines.next();
                Block::Listing(code)
            }
            [b'|', ..] => Block::Table(table(&rest(line, &|next| next.starts_with('|')))),
            [b'-', b' ', ..] => Block::List(vec![plain(&rest(&line[2..], &is_plain).join(" "))]),
            _ => Block::Text(plain(&rest(line, &is_plain).join(" "))),
        };
        push(&mut sections, block);
    }
    Page {
        title: "Plant files, format 1".into(),
        verdict: "A plant file describes a system: bodies, tanks, appendages, inputs, sensors and effects. \
                  Every number has a unit, and a prior where it is uncertain."
            .into(),
        sections,
        command: "obsid plant format --html FILE".into(),
        tool: tool(),
        ..Page::default()
    }
}

/// Adds a block to the last section; entries of one list stay together.
fn push(sections: &mut [Section], block: Block) {
    let Some(section) = sections.last_mut() else { return };
    match (section.blocks.last_mut(), block) {
        (Some(Block::List(items)), Block::List(more)) => items.extend(more),
        (_, block) => section.blocks.push(block),
    }
}

fn table(lines: &[String]) -> Table {
    let cells = |line: &str| -> Vec<String> {
        line.trim_matches('|').split(" | ").map(|cell| plain(cell.trim_matches(['|', ' ']))).collect()
    };
    let mut rows = lines.iter().map(|line| cells(line));
    let columns = rows.next().unwrap_or_default();
    let rows = rows.skip(1).map(|row| row.into_iter().map(Cell::Prose).collect()).collect();
    Table { caption: String::new(), columns, rows }
}

/// Text without the marks of Markdown.
fn plain(text: &str) -> String {
    text.replace("**", "").replace('`', "")
}

#[test]
fn the_page_shows_every_heading_key_and_row_of_the_definition() {
    let html = String::from_utf8(page(plant_file::FORMAT).html()).unwrap();
    for line in plant_file::FORMAT.lines() {
        if let Some(title) = line.strip_prefix("## ") {
            assert!(html.contains(&format!("<h2>{title}</h2>")), "{title}");
        }
        if let Some(kind) = line.strip_prefix("| `").and_then(|rest| rest.split('`').next()) {
            assert!(html.contains(kind), "{kind}");
        }
        let key = line.split(" = ").next().unwrap_or("");
        if line.contains(" = ") && key.chars().all(|c| c.is_ascii_lowercase() || c == '_') {
            assert!(html.contains(key), "{key}");
        }
    }
    assert!(html.matches("<table").count() >= 3 && html.matches("<pre>").count() >= 7 && !html.contains("**"));
}
