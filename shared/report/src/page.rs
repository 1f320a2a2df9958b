//! The page: title, verdict, sections, footer.

use crate::style;
use crate::svg::Figure;
use crate::table::Table;
use crate::text::escape;
use std::fmt::Write;

/// Readout under the pointer, zoom by dragging, reset by a double click; paper unfolds what is
/// folded.
const SCRIPT: &str = include_str!("page.js");
/// Motion of [`crate::Structure`], where a page has one.
const STRUCTURE: &str = include_str!("structure.js");

/// Part of a section.
#[derive(Clone, Debug, PartialEq)]
pub enum Block {
    Text(String),
    List(Vec<String>),
    /// A line to type.
    Command(String),
    /// A text file as it is, line by line.
    Listing(String),
    Table(Table),
    Figure(Figure),
    /// Closed until the reader opens it; open on paper.
    Details {
        summary: String,
        blocks: Vec<Block>,
    },
}

/// Part of a page under a heading.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Section {
    pub title: String,
    pub blocks: Vec<Block>,
}

impl Section {
    /// A section of `blocks` under `title`.
    #[must_use]
    pub fn new(title: &str, blocks: Vec<Block>) -> Self {
        Section { title: title.into(), blocks }
    }
}

/// A report for an engineer who reads the first paragraph, and then the figures.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Page {
    pub title: String,
    /// The first paragraph.
    pub verdict: String,
    pub sections: Vec<Section>,
    /// The command that wrote the page.
    pub command: String,
    /// Names of the inputs, each with its digest.
    pub digests: Vec<(String, String)>,
    /// Name and version of the program.
    pub tool: String,
}

impl Page {
    /// The page as the bytes of one file.
    #[must_use]
    pub fn html(&self) -> Vec<u8> {
        let title = escape(&self.title);
        let mut html = format!(
            "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/><meta name=\"viewport\" content=\"width=device-width,initial-scale=1\"/><title>{title}</title>\n<style>{}</style></head>\n<body><main>\n<h1>{title}</h1>\n<p class=\"verdict\">{}</p>\n",
            style::of_page(),
            with_commands(&self.verdict)
        );
        for section in &self.sections {
            let _ = writeln!(html, "<section><h2>{}</h2>", escape(&section.title));
            blocks(&mut html, &section.blocks);
            html.push_str("</section>\n");
        }
        self.footer(&mut html);
        let motion = if html.contains(" data-structure=") { STRUCTURE } else { "" };
        let _ = writeln!(html, "</main><script>\n{SCRIPT}{motion}</script></body></html>");
        html.into_bytes()
    }

    fn footer(&self, html: &mut String) {
        html.push_str("<footer>");
        if !self.command.is_empty() {
            let _ = write!(html, "<p>Written by <code>{}</code></p>", escape(&self.command));
        }
        if !self.digests.is_empty() {
            html.push_str("<p>Digests:</p><ul>");
            for (what, digest) in &self.digests {
                let _ = write!(html, "<li>{} <code>{}</code></li>", escape(what), escape(digest));
            }
            html.push_str("</ul>");
        }
        let _ = writeln!(html, "<p>{}</p></footer>", escape(&self.tool));
    }
}

fn blocks(html: &mut String, blocks_of: &[Block]) {
    for block in blocks_of {
        match block {
            Block::Text(text) => {
                let _ = writeln!(html, "<p>{}</p>", with_commands(text));
            }
            Block::List(items) => {
                html.push_str("<ul>");
                items.iter().for_each(|item| html.push_str(&format!("<li>{}</li>", escape(item))));
                html.push_str("</ul>\n");
            }
            Block::Command(line) => {
                let _ = writeln!(html, "<p><code>{}</code></p>", escape(line));
            }
            Block::Listing(text) => {
                let _ = writeln!(html, "<pre>{}</pre>", escape(text));
            }
            Block::Table(table) => html.push_str(&table.html()),
            Block::Figure(figure) => html.push_str(&with_caption(figure)),
            Block::Details { summary, blocks: inner } => {
                let _ = writeln!(html, "<details><summary>{}</summary>", escape(summary));
                blocks(html, inner);
                html.push_str("</details>\n");
            }
        }
    }
}

/// Text whose parts between backticks are commands or files.
fn with_commands(text: &str) -> String {
    let parts: Vec<&str> = text.split('`').collect();
    if parts.len().is_multiple_of(2) {
        return escape(text);
    }
    let part = |(k, part): (usize, &&str)| {
        if k.is_multiple_of(2) { escape(part) } else { format!("<code>{}</code>", escape(part)) }
    };
    parts.iter().enumerate().map(part).collect()
}

fn with_caption(figure: &Figure) -> String {
    let mut html = format!("<figure><h3>{}</h3>{}<figcaption>", escape(&figure.title), figure.inline());
    html.push_str(&escape(&figure.caption));
    if !figure.command.is_empty() {
        let _ = write!(html, " <code>{}</code>", escape(&figure.command));
    }
    html.push_str(&figure.data_link());
    html.push_str("</figcaption></figure>\n");
    html
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_stands_between_backticks_is_a_command_and_a_single_backtick_is_itself() {
        assert_eq!(with_commands("run `a <b>` now"), "run <code>a &lt;b&gt;</code> now");
        assert_eq!(with_commands("a ` b"), "a ` b");
    }
}
