//! `report.html`: the report as a page to look at, which needs nothing beside it.

use super::chart::{Chart, escaped, svg};
use super::document::{Object, Report};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::fmt::Write;

const STYLE: &str = "\
:root{color-scheme:light;--ink:#24262a;--soft:#6d7178;--line:#e4e4e1;--accent:#0a6ebd}
body{margin:0;background:#fafaf9;color:var(--ink);font:15px/1.5 system-ui,sans-serif}
main{max-width:1120px;margin:0 auto;padding:40px 24px 64px}
h1{font-size:28px;margin:0}h2{font-size:18px;margin:44px 0 12px}p{margin:4px 0}.soft{color:var(--soft)}
.numbers{display:flex;flex-wrap:wrap;gap:12px;margin:24px 0}
.numbers div{background:#fff;border:1px solid var(--line);border-radius:10px;padding:12px 18px;min-width:120px}
.numbers b{display:block;font-size:22px;font-variant-numeric:tabular-nums}
.compare{position:relative;border:1px solid var(--line);border-radius:10px;overflow:hidden;--at:50%}
.compare img{display:block;width:100%}
.compare img+img{position:absolute;inset:0;clip-path:inset(0 0 0 var(--at))}
.compare i{position:absolute;top:0;bottom:0;left:var(--at);width:2px;margin-left:-1px;background:#fff;box-shadow:0 0 4px #0006}
.compare input{position:absolute;inset:0;width:100%;height:100%;margin:0;opacity:0;cursor:ew-resize}
.compare span{position:absolute;top:12px;padding:2px 10px;border-radius:12px;background:#fffc;font-size:13px}
.compare span.right{right:12px}.compare span.left{left:12px}
table{border-collapse:collapse;width:100%;background:#fff;border:1px solid var(--line)}
th,td{padding:7px 12px;border-bottom:1px solid var(--line);text-align:right;font-variant-numeric:tabular-nums}
th{font-weight:600;color:var(--soft);font-size:13px}th:first-child,td:first-child,td.state,th.state{text-align:left}
td:first-child{overflow-wrap:anywhere}
.bar{display:inline-block;height:8px;border-radius:4px;background:var(--accent);opacity:.55;margin-right:8px}
.state b{font-weight:600}.good{color:#1d7a46}.bad{color:#b3261e}
.charts{display:flex;flex-wrap:wrap;gap:12px}.charts svg{border:1px solid var(--line);border-radius:10px}";

/// Widest bar of the table, px.
const BAR: f64 = 120.0;

/// The page. `pictures` are before and after as PNG files, if they could be drawn.
pub fn html(report: &Report<'_>, pictures: Option<[&[u8]; 2]>) -> String {
    let name = escaped(report.scene);
    let mut page = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\"><title>{name}</title>\n<style>\n{STYLE}\n</style></head>\n\
         <body><main>\n<h1>{name}</h1>\n"
    );
    // Writing to a String cannot fail.
    let _ = write_page(&mut page, report, pictures);
    page + "</main></body></html>\n"
}

fn write_page(out: &mut String, report: &Report<'_>, pictures: Option<[&[u8]; 2]>) -> std::fmt::Result {
    let (summary, run) = (&report.summary, &report.run);
    let input = escaped(run.input);
    let unfinished = if report.finished { "" } else { ", stopped before the end" };
    let backend = escaped(run.backend);
    writeln!(out, "<p class=\"soft\">{input}, simulated by {backend}, seed {}{unfinished}</p>", run.seed)?;
    writeln!(out, "<div class=\"numbers\">")?;
    let mut number = |value: String, what: &str| writeln!(out, "<div><b>{value}</b>{what}</div>");
    number(format!("{} of {}", summary.stable, summary.simulated), "objects stand still")?;
    number(millimetres(summary.mean_drift), "mean drift in the check")?;
    number(millimetres(summary.mean_moved), "moved on average")?;
    number(millimetres(summary.max_moved), "moved at most")?;
    number(summary.fallen.len().to_string(), "fell over")?;
    number(summary.lost_support.len().to_string(), "lost their support")?;
    writeln!(out, "</div>")?;
    if let Some([before, after]) = pictures {
        let image = |png: &[u8], what: &str| {
            format!("<img alt=\"{what}\" src=\"data:image/png;base64,{}\">", STANDARD.encode(png))
        };
        writeln!(
            out,
            "<div class=\"compare\">{}{}<i></i><span class=\"left\">before</span><span class=\"right\">after</span>\
             <input type=\"range\" min=\"0\" max=\"100\" value=\"50\" aria-label=\"before and after\" \
             oninput=\"this.parentNode.style.setProperty('--at',this.value+'%')\"></div>",
            image(before, "The scene as it came"),
            image(after, "The result from the same camera")
        )?;
    }
    writeln!(
        out,
        "<h2>Objects</h2>\n<table><tr><th>object</th><th>moved</th><th>turned</th><th>drift in the check</th>"
    )?;
    writeln!(out, "<th>deepest overlap</th><th class=\"state\">in the check</th></tr>")?;
    let mut objects: Vec<&Object<'_>> = report.objects.iter().collect();
    objects.sort_by(|a, b| {
        (b.simulated, b.moved).partial_cmp(&(a.simulated, a.moved)).unwrap_or(std::cmp::Ordering::Equal)
    });
    let longest = objects.iter().map(|object| object.moved).fold(f64::MIN_POSITIVE, f64::max);
    for object in objects {
        let (state, class) = state(object);
        writeln!(
            out,
            "<tr><td>{}</td><td><span class=\"bar\" style=\"width:{:.0}px\"></span>{}</td><td>{:.1}°</td><td>{}</td>\
             <td>{}</td><td class=\"state\"><b class=\"{class}\">{state}</b></td></tr>",
            escaped(object.name),
            BAR * object.moved / longest,
            millimetres(object.moved),
            object.turned.to_degrees(),
            millimetres(object.check.drift),
            millimetres(object.check.terms.penetration),
        )?;
    }
    writeln!(out, "</table>")?;
    if !report.mesh_overlaps.is_empty() {
        writeln!(out, "<h2>Meshes that still overlap</h2>")?;
        for overlap in &report.mesh_overlaps {
            let depth = overlap.depth.map_or_else(|| "deep".into(), millimetres);
            writeln!(out, "<p>{} and {}: {depth}</p>", escaped(overlap.a), escaped(overlap.b))?;
        }
    }
    let charts: Vec<Chart> = (0..report.groups.len()).filter_map(|group| chart(report, group)).collect();
    if !charts.is_empty() {
        writeln!(out, "<h2>Energy of the best layout</h2>\n<div class=\"charts\">")?;
        for chart in &charts {
            out.push_str(&svg("", std::slice::from_ref(chart)));
        }
        writeln!(out, "</div>")?;
    }
    if !report.notes.is_empty() {
        writeln!(out, "<h2>Notes</h2>")?;
        for note in &report.notes {
            writeln!(out, "<p>{}</p>", escaped(note))?;
        }
    }
    Ok(())
}

/// The course of a group's search, if there was one.
fn chart(report: &Report<'_>, group: usize) -> Option<Chart> {
    let of_group = report.iterations.iter().filter(|iteration| iteration.group == group);
    let points: Vec<(f64, f64)> = of_group
        .map(|iteration| (f64::from(iteration.iteration) + 1.0, f64::from(iteration.best.total)))
        .filter(|point| point.1.is_finite())
        .collect();
    let title = report.groups[group].name.to_owned();
    (points.len() > 1).then(|| Chart { title, x: "iteration".into(), y: "energy".into(), points })
}

fn state(object: &Object<'_>) -> (&'static str, &'static str) {
    match object {
        Object { simulated: false, .. } => ("held in place", "soft"),
        Object { stable: false, .. } => ("unstable", "bad"),
        Object { fallen: true, .. } => ("fell over", "bad"),
        Object { lost_support: true, .. } => ("lost its support", "bad"),
        _ => ("stands still", "good"),
    }
}

fn millimetres(length: f64) -> String {
    format!("{:.1} mm", 1e3 * length)
}
