//! Colours and type, for the page and for a figure on its own. Everything has two forms, light and
//! dark; paper is light.

use std::fmt::Write;

/// Levels of a colour scale.
pub const LEVELS: usize = 16;

type Rgb = [i32; 3];

/// From zero to the one colour and beyond, on a light and on a dark page.
const SEQUENTIAL: [[Rgb; 4]; 2] = [
    [[244, 246, 248], [150, 190, 232], [20, 102, 200], [6, 38, 88]],
    [[24, 29, 35], [26, 76, 134], [88, 166, 255], [228, 241, 255]],
];
/// From one sign through zero to the other.
const DIVERGING: [[Rgb; 5]; 2] = [
    [[8, 60, 130], [110, 165, 225], [245, 245, 243], [240, 165, 100], [160, 66, 6]],
    [[150, 200, 255], [45, 105, 175], [32, 36, 42], [180, 95, 30], [255, 190, 130]],
];

const LIGHT: &str = "--paper:#fff;--ink:#16191d;--faint:#5c6670;--grey:#8b939c;--rule:#d9dee3;--grid:#e9edf0;--plot:#fcfdfd;--one:#1466c8;--band:rgba(20,102,200,.18);--mark:rgba(214,134,20,.20);--note:#4d6478;--warning:#9a5b00;--fault:#b3261e;--code:#f1f4f6;--on-high:#fff;color-scheme:light;";
const DARK: &str = "--paper:#14181c;--ink:#e8ebee;--faint:#a0a9b2;--grey:#7d8690;--rule:#343b43;--grid:#262c33;--plot:#181d22;--one:#58a6ff;--band:rgba(88,166,255,.22);--mark:rgba(230,160,60,.22);--note:#9db4c9;--warning:#e3a84f;--fault:#ff8a80;--code:#1f252b;--on-high:#0c0f12;color-scheme:dark;";

const FIGURE: &str = "
.figure{font:12px system-ui,-apple-system,'Segoe UI','Helvetica Neue',Arial,sans-serif}
.figure text{fill:var(--ink)}.figure .tick{fill:var(--faint)}.figure .faint{fill:var(--faint)}.figure .claim{font-size:14px;font-weight:600}
.figure .middle{text-anchor:middle}.figure .end{text-anchor:end}.figure .strong{font-weight:600}.figure .on-high{fill:var(--on-high)}
.paper{fill:var(--paper)}.plot{fill:var(--plot)}.frame{fill:none;stroke:var(--rule)}.grid{stroke:var(--grid)}.zero{stroke:var(--grey)}
.line{fill:none;stroke-width:1.4;stroke-linejoin:round;stroke-linecap:round}.dot{fill:none;stroke-width:3;stroke-linecap:round}
.measured{stroke:var(--ink)}.line.measured{stroke-width:2.2}.before{stroke:var(--grey)}.after{stroke:var(--one)}.truth{stroke:var(--ink);stroke-dasharray:6 4;stroke-width:1.3}
.line.before,.line.after{stroke-width:1.6}.rival{stroke:var(--grey);stroke-dasharray:2 3}.small{stroke-width:2}
.area.band{fill:var(--band)}.area.mark{fill:var(--mark)}.after-fill{fill:var(--one)}.before-fill{fill:var(--grey)}.measured-fill{fill:var(--ink)}
.ring{fill:none;stroke-width:1.4}.halo{stroke:var(--plot)}.panel path,.panel line{vector-effect:non-scaling-stroke}
.catch{fill:transparent}.chosen{fill:var(--band)}.panel{touch-action:pan-y}
";

const PAGE: &str = "
*{box-sizing:border-box}body{margin:0;background:var(--paper);color:var(--ink);font:16px/1.5 system-ui,-apple-system,'Segoe UI','Helvetica Neue',Arial,sans-serif}
main{max-width:840px;margin:0 auto;padding:32px 24px 64px}h1,h2{overflow-wrap:anywhere}h1{font-size:1.6rem;line-height:1.25;margin:0 0 12px}h2{font-size:1.2rem;margin:40px 0 8px;padding-top:12px;border-top:1px solid var(--rule)}
p{margin:8px 0;overflow-wrap:anywhere}.verdict{font-size:1.15rem;border-left:4px solid var(--one);padding:4px 0 4px 14px;margin:0 0 20px}
figure{margin:24px 0}figure h3{font-size:1rem;margin:0 0 6px;overflow-wrap:anywhere}figure svg{display:block;width:100%;height:auto}figcaption,footer,.faint{color:var(--faint);font-size:.85rem}figcaption{margin-top:4px}
code{font:.85em ui-monospace,SFMono-Regular,Menlo,Consolas,monospace;background:var(--code);padding:1px 4px;border-radius:3px;overflow-wrap:anywhere}
pre{overflow-x:auto;background:var(--code);padding:10px 12px;border-radius:3px;line-height:1.35}pre code{padding:0;overflow-wrap:normal}
.wide{overflow-x:auto;margin:12px 0}table{border-collapse:collapse;font-size:.875rem;min-width:60%}caption{caption-side:top;text-align:left;font-weight:600;padding:0 0 4px}
th,td{text-align:left;vertical-align:top;padding:5px 14px 5px 0;border-bottom:1px solid var(--rule)}th{color:var(--faint);font-weight:600}td:last-child,th:last-child{padding-right:0}
td.n,th.n{text-align:right;white-space:nowrap;font-variant-numeric:tabular-nums}.i,.f{display:inline-block;white-space:nowrap}.i{text-align:right}.f{text-align:left}td.prose{min-width:7em;overflow-wrap:anywhere}td.prose:last-child{min-width:13em}td.name{overflow-wrap:break-word}
.s-note{color:var(--note)}.s-warning{color:var(--warning);font-weight:600}.s-fault{color:var(--fault);font-weight:600}
details{margin:14px 0}summary{cursor:pointer;font-weight:600}footer{margin-top:48px;border-top:1px solid var(--rule);padding-top:12px}ul{margin:8px 0;padding-left:22px}
pre{font:.8em ui-monospace,SFMono-Regular,Menlo,Consolas,monospace;background:var(--code);padding:8px 10px;border-radius:3px;overflow-x:auto;white-space:pre-wrap;overflow-wrap:anywhere}
.readout{position:fixed;z-index:1;pointer-events:none;background:var(--paper);color:var(--ink);border:1px solid var(--rule);border-radius:3px;padding:3px 8px;font-size:.8rem;font-variant-numeric:tabular-nums;max-width:60vw}.readout[hidden]{display:none}
.controls{display:flex;flex-wrap:wrap;gap:6px 16px;align-items:center;margin:0 0 8px;font-size:.85rem;color:var(--faint)}.controls button,.controls select{font:inherit;color:var(--ink);background:var(--code);border:1px solid var(--rule);border-radius:3px;padding:2px 10px;max-width:100%}.controls button{min-width:5em}.controls label{display:inline-flex;gap:6px;align-items:center}.controls input{accent-color:var(--one);width:8em}
@media (max-width:560px){main{padding:20px 14px 48px}table{font-size:.8rem;min-width:100%}th,td{padding-right:6px}th.n,td.n{white-space:normal}.i,.f{display:inline;white-space:normal}td.prose,td.prose:last-child{min-width:6.5em}td.name{max-width:11em}}
@media print{main{max-width:none;padding:0}figure,tr{break-inside:avoid}thead{display:table-header-group}h2,h3,summary{break-after:avoid}details::details-content{content-visibility:visible;display:block}.wide{overflow:visible}table{width:100%;min-width:0;font-size:.75rem}th,td{overflow-wrap:anywhere;padding-right:8px}td.prose{min-width:0}.data,.readout,.controls{display:none}*{print-color-adjust:exact;-webkit-print-color-adjust:exact}}
";

/// Styles of a page with figures.
pub fn of_page() -> String {
    format!("{}{PAGE}", of_figure())
}

/// Styles that a figure needs.
pub fn of_figure() -> String {
    let mut css = format!(":root{{{LIGHT}{}}}", scales(0));
    // Paper stays light whatever the screen is.
    let _ = write!(css, "@media screen and (prefers-color-scheme:dark){{:root{{{DARK}{}}}}}", scales(1));
    css.push_str(FIGURE);
    for level in 0..LEVELS {
        let _ = write!(
            css,
            ".q{level}{{fill:var(--q{level});shape-rendering:crispEdges}}.d{level}{{fill:var(--d{level});shape-rendering:crispEdges}}"
        );
    }
    css.push('\n');
    css
}

fn scales(form: usize) -> String {
    let mut css = String::new();
    for level in 0..LEVELS {
        let [r, g, b] = between(&SEQUENTIAL[form], level);
        let _ = write!(css, "--q{level}:rgb({r},{g},{b});");
        let [r, g, b] = between(&DIVERGING[form], level);
        let _ = write!(css, "--d{level}:rgb({r},{g},{b});");
    }
    css
}

/// Colour of a level: straight lines between the stops, in whole numbers.
fn between(stops: &[Rgb], level: usize) -> Rgb {
    let (spans, steps) = (stops.len() - 1, LEVELS - 1);
    let span = (level * spans / steps).min(spans - 1);
    let part = (level * spans - span * steps) as i32;
    std::array::from_fn(|i| stops[span][i] + (stops[span + 1][i] - stops[span][i]) * part / steps as i32)
}
