//! What holds for every page and every figure.

mod gallery;

use report::{Block, Page, Section};

/// Names of the elements that are open at the end of each tag; panics where a tag closes what is
/// not open.
fn check_balanced(text: &str) {
    let mut open: Vec<&str> = Vec::new();
    let mut rest = text.strip_prefix("<!DOCTYPE html>").unwrap_or(text);
    while let Some(start) = rest.find('<') {
        assert!(!rest[..start].contains('>'), "a bare > in {}", &rest[..start]);
        let end = start + rest[start..].find('>').expect("a tag ends");
        let tag = &rest[start + 1..end];
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name), "{}", &rest[..end.min(200)]);
        } else if !tag.ends_with('/') {
            let name = tag.split_whitespace().next().unwrap();
            // what they hold is no markup
            if let "style" | "script" = name {
                let close = format!("</{name}>");
                rest = &rest[rest.find(&close).expect("it ends") + close.len()..];
                continue;
            }
            open.push(name);
        }
        assert_eq!(tag.matches('"').count() % 2, 0, "quotes of {tag}");
        rest = &rest[end + 1..];
    }
    assert!(open.is_empty(), "{open:?} stay open");
}

fn html(page: &Page) -> String {
    String::from_utf8(page.html()).expect("UTF-8")
}

#[test]
fn a_page_is_well_formed_and_fetches_nothing() {
    let text = html(&gallery::page());
    check_balanced(&text);
    for outside in ["http:", "https:", "//cdn", "<script ", "fetch(", "<link", "<iframe", "<img", "@import", "url("] {
        assert!(!text.contains(outside), "{outside}");
    }
    assert!(!text.contains("NaN") && !text.contains("inf\"") && !text.contains("infin"));
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    assert!(gallery::page().html() == gallery::page().html());
}

#[test]
fn the_verdict_is_the_first_paragraph() {
    let text = html(&gallery::page());
    let first = text.split_once("<p").expect("a paragraph").1;
    assert!(first.starts_with(" class=\"verdict\">Named: joint_coulomb@joint:pivot"), "{}", &first[..80]);
}

#[test]
fn a_figure_on_its_own_is_a_well_formed_file() {
    for figure in gallery::figures() {
        let text = String::from_utf8(figure.document()).expect("UTF-8");
        check_balanced(&text);
        assert_eq!(text.matches("xmlns=\"http://www.w3.org/2000/svg\"").count(), text.matches("http").count());
    }
}

#[test]
fn without_data_a_figure_says_so() {
    for figure in gallery::empty_figures() {
        let text = figure.inline();
        check_balanced(&text);
        let says = text.contains(">no data<") || text.contains(">–<");
        assert!(says && !text.contains("NaN"), "{}: {text}", figure.title);
    }
}

#[test]
fn every_text_of_a_figure_lies_inside_it() {
    for figure in gallery::figures().into_iter().chain(gallery::empty_figures()) {
        let text = figure.inline();
        let (_, body) = text.split_once('>').unwrap();
        let mut inner_left = 0.0;
        for element in body.split('<') {
            let number = |name: &str| -> f64 {
                let (_, rest) = element.split_once(&format!(" {name}=\"")).unwrap();
                rest.split_once('"').unwrap().0.parse().unwrap()
            };
            if element.starts_with("svg ") {
                inner_left = number("x");
            } else if element.starts_with("/svg") {
                inner_left = 0.0;
            }
            // Turned text is bounded by its own width along the panel.
            if !element.starts_with("text ") || element.contains("rotate(") {
                continue;
            }
            let words = element.split_once('>').unwrap().1;
            let (x, width) = (inner_left + number("x"), 12.0 * report::text::width_em(words));
            let left = if element.contains("middle\"") {
                x - width / 2.0
            } else if element.contains(" end\"") {
                x - width
            } else {
                x
            };
            // The estimate is an upper one: a few pixels over the border still fit.
            assert!(left > -4.0 && left + width < 764.0, "{}: `{words}` from {left} to {}", figure.title, left + width);
        }
    }
}

#[test]
fn a_long_record_is_drawn_within_bounds_and_keeps_its_spike() {
    let size = |n| gallery::overlay(n).inline().len();
    assert!(size(200_000) < 200_000, "{} bytes", size(200_000));
    // One sample of 200 000, a third along, stands 0.9 rad above a swing of 0.4 rad.
    let text = gallery::overlay(200_000).inline();
    let measured = text.split("class=\"line measured\" d=\"").nth(1).expect("the samples");
    let numbers = |point: &str| -> Option<(f64, f64)> {
        let (x, y) = point.split_once(' ')?;
        Some((x.parse().ok()?, y.parse().ok()?))
    };
    let points: Vec<(f64, f64)> = measured.split('"').next().unwrap().split(['M', 'L']).filter_map(numbers).collect();
    let width = points.iter().fold(0.0, |m: f64, p| m.max(p.0));
    let highest = |from: f64, to: f64| {
        points.iter().filter(|p| (from..to).contains(&(p.0 - width / 3.0))).fold(f64::INFINITY, |m, p| m.min(p.1))
    };
    let around = highest(-40.0, -3.0).min(highest(3.0, 40.0));
    assert!(highest(-2.0, 2.0) < around - 15.0, "{} against {around}", highest(-2.0, 2.0));
}

#[test]
fn measured_dots_are_drawn_after_every_model() {
    for count in [60, 300, 20_000] {
        let text = gallery::overlay(count).inline();
        let (dots, model) = (text.rfind("dot measured"), text.find("line after"));
        // the legend comes first, the residual panel after the main one
        let main = text.split("</svg>").next().unwrap();
        assert!(main.rfind("dot measured") > main.rfind("line after"), "{count} samples");
        assert!(dots.is_some() && model.is_some());
    }
}

#[test]
fn every_figure_offers_its_data_within_bounds_and_every_panel_its_axes() {
    let text = html(&gallery::page());
    let figures = text.matches("<figure>").count();
    assert_eq!(text.matches("href=\"data:text/csv;charset=utf-8,").count(), figures);
    for link in text.split("href=\"data:text/csv").skip(1) {
        assert!(link.find('"').unwrap() < 250_000);
    }
    for panel in text.split("<svg class=\"panel\"").skip(1) {
        let tag = panel.split('>').next().unwrap();
        assert!(tag.contains(" data-x=\"") && tag.contains(" data-y=\"") && tag.contains(" data-xname=\""), "{tag}");
    }
    // each panel has one group of ticks, which the zoom replaces
    assert_eq!(text.matches("<svg class=\"panel\"").count(), text.matches("<g class=\"xticks\"").count());
}

#[test]
fn a_listing_keeps_its_lines_and_tables_can_scroll() {
    let listing = Block::Listing("format = 1\n[a]\nb = \"<c>\"\n".into());
    let page = Page { sections: vec![Section::new("Next", vec![listing])], ..Page::default() };
    assert!(html(&page).contains("<pre>format = 1\n[a]\nb = &quot;&lt;c&gt;&quot;\n</pre>"));
    let text = html(&gallery::page());
    assert_eq!(text.matches("<table>").count(), text.matches("<div class=\"wide\"><table>").count());
    assert!(text.contains("@media print") && text.contains("@media (max-width:560px)"));
}

#[test]
fn text_from_outside_stays_text() {
    let evil = "</p><script>alert(1)</script>\u{0}";
    let page = Page {
        title: evil.into(),
        verdict: evil.into(),
        sections: vec![Section::new(evil, vec![Block::Text(evil.into()), Block::Command(evil.into())])],
        ..Page::default()
    };
    let text = html(&page);
    check_balanced(&text);
    // the one of the page itself
    assert!(text.matches("<script").count() == 1 && !text.contains('\u{0}'));
}

#[test]
fn a_map_of_both_signs_can_be_read_without_colour() {
    let text = gallery::state_map().inline();
    assert!(text.matches(">−<").count() > 20 && text.matches(">+<").count() > 20);
    // the lower half pushes back, the upper half forward: what is written lies where the number
    // says
    let rows = |sign: &str| -> Vec<f64> {
        let places = text.split("<text ").filter(|t| t.contains(&format!(">{sign}<")));
        places.map(|t| t.split(" y=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap()).collect()
    };
    let mean = |y: Vec<f64>| y.iter().sum::<f64>() / y.len() as f64;
    assert!(mean(rows("−")) > mean(rows("+")) + 50.0);
}
