//! Curves as one SVG file that needs nothing else: no fonts, scripts or styles from outside.

use std::fmt::Write;

/// One curve over a logarithmic axis of sizes; values start at 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// What stands above it.
    pub title: String,
    /// What the sizes are.
    pub x: String,
    /// What the values are, with their unit.
    pub y: String,
    /// Size, above 0, and value; from small to large.
    pub points: Vec<(f64, f64)>,
}

/// Size of a chart with its labels, and of the margins around its frame: left, top, right, bottom, px.
const SIZE: [f64; 2] = [360.0, 280.0];
const MARGINS: [f64; 4] = [64.0, 36.0, 20.0, 44.0];
/// Height of the heading above the charts, px.
const HEADING: f64 = 36.0;
/// Room for a size along the axis, px.
const LABEL: f64 = 26.0;
/// About how many intervals the axis of values has.
const INTERVALS: f64 = 5.0;

/// All charts side by side under a heading.
pub fn svg(heading: &str, charts: &[Chart]) -> String {
    let [width, height] = [SIZE[0] * charts.len().max(1) as f64, SIZE[1] + HEADING];
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"11\" fill=\"#222\">\n\
         <title>{0}</title>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n\
         <text x=\"16\" y=\"24\" font-size=\"14\" font-weight=\"bold\">{0}</text>\n",
        escaped(heading)
    );
    for (i, chart) in charts.iter().enumerate() {
        // Writing to a String cannot fail.
        let _ = writeln!(out, "<g transform=\"translate({} {HEADING})\">", SIZE[0] * i as f64);
        draw(chart, &mut out);
        out += "</g>\n";
    }
    out + "</svg>\n"
}

/// The curve in its frame, with the sizes and round values as ticks.
fn draw(chart: &Chart, out: &mut String) {
    let [left, top, right, bottom] = [MARGINS[0], MARGINS[1], SIZE[0] - MARGINS[2], SIZE[1] - MARGINS[3]];
    let points: Vec<(f64, f64)> =
        chart.points.iter().copied().filter(|(x, y)| *x > 0.0 && x.is_finite() && y.is_finite()).collect();
    let highest = points.iter().map(|point| point.1).fold(0.0, f64::max);
    let step = round_step(if highest > 0.0 { highest } else { 1.0 } / INTERVALS);
    let intervals = (highest / step).ceil().max(1.0);
    let (first, last) =
        points.iter().map(|point| point.0).fold((f64::INFINITY, 0.0_f64), |(l, h), x| (l.min(x), h.max(x)));
    let span = (last / first).ln();
    let across = |x: f64| {
        let share = if span > 0.0 { (x / first).ln() / span } else { 0.5 };
        left + share * (right - left)
    };
    let up = |y: f64| bottom - y / (intervals * step) * (bottom - top);
    let middle = 0.5 * (left + right);
    let mut text = |x: f64, y: f64, attributes: &str, text: &str| {
        let _ = writeln!(out, "<text x=\"{x:.1}\" y=\"{y:.1}\" {attributes}>{}</text>", escaped(text));
    };
    text(middle, top - 14.0, "text-anchor=\"middle\" font-weight=\"bold\"", &chart.title);
    text(middle, SIZE[1] - 8.0, "text-anchor=\"middle\"", &chart.x);
    let turned = format!("text-anchor=\"middle\" transform=\"rotate(-90 12 {:.1})\"", 0.5 * (top + bottom));
    text(12.0, 0.5 * (top + bottom), &turned, &chart.y);
    for y in (0..=intervals as u32).map(|i| f64::from(i) * step) {
        text(left - 6.0, up(y) + 4.0, "text-anchor=\"end\"", &short(y));
    }
    let mut free = f64::NEG_INFINITY;
    for &(x, _) in &points {
        // A size that would be written over the one before is left out.
        if across(x) >= free {
            text(across(x), bottom + 16.0, "text-anchor=\"middle\"", &short(x));
            free = across(x) + LABEL;
        }
    }
    for y in (0..=intervals as u32).map(|i| up(f64::from(i) * step)) {
        let _ = writeln!(out, "<path d=\"M{left:.1} {y:.1}H{right:.1}\" stroke=\"#ddd\"/>");
    }
    let _ = writeln!(out, "<path d=\"M{left:.1} {top:.1}V{bottom:.1}H{right:.1}\" fill=\"none\" stroke=\"#222\"/>");
    let places: Vec<String> = points.iter().map(|&(x, y)| format!("{:.1},{:.1}", across(x), up(y))).collect();
    let _ = writeln!(
        out,
        "<polyline points=\"{}\" fill=\"none\" stroke=\"#0a6ebd\" stroke-width=\"2\"/>",
        places.join(" ")
    );
    for &(x, y) in &points {
        let _ = writeln!(
            out,
            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"3\" fill=\"#0a6ebd\"><title>{}: {}</title></circle>",
            across(x),
            up(y),
            short(x),
            short(y)
        );
    }
}

/// The smallest of 1, 2 and 5 times a power of ten that is at least `least`, which is above 0.
fn round_step(least: f64) -> f64 {
    let power = 10.0_f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0].map(|digit| digit * power).into_iter().find(|step| *step >= least).unwrap_or(10.0 * power)
}

/// At most four digits, with k and M for thousands and millions.
fn short(value: f64) -> String {
    let digits = |value: f64| {
        let decimals = match value {
            v if v >= 100.0 => 0,
            // Two digits of what is small.
            v if v > 0.0 && v < 0.1 => (1.0 - v.log10().floor()).min(9.0) as usize,
            _ => 2,
        };
        let text = format!("{value:.decimals$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    };
    match value {
        v if v >= 1e6 => format!("{} M", digits(v / 1e6)),
        v if v >= 1e5 => format!("{} k", digits(v / 1e3)),
        v => digits(v),
    }
}

/// A text inside an element or attribute of XML or HTML; characters that XML does not know become blanks.
pub(super) fn escaped(text: &str) -> String {
    let text: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn chart(points: &[(f64, f64)]) -> Chart {
        Chart { title: "a < b & c".into(), x: "bodies".into(), y: "1/s".into(), points: points.to_vec() }
    }

    #[test]
    fn a_file_is_whole_and_holds_every_point() {
        let charts = [chart(&[(64.0, 10.0), (256.0, 99.0), (1024.0, 40.0)]), chart(&[(4.0, 1e7)])];
        let text = svg("study <on> \"CPU\"\u{1b}", &charts);
        let document = roxmltree::Document::parse(&text).unwrap();
        let named = |name: &str| document.descendants().filter(|n| n.has_tag_name(name)).count();
        assert!(document.root_element().has_tag_name(("http://www.w3.org/2000/svg", "svg")));
        assert_eq!((named("g"), named("polyline"), named("circle")), (2, 2, 4));
        assert!(document.descendants().any(|n| n.text() == Some("a < b & c")));
        assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
    }

    #[test]
    fn curves_run_from_left_to_right_inside_their_frame() {
        let text = svg("", &[chart(&[(4.0, 0.0), (8.0, 50.0), (16.0, 100.0)])]);
        let document = roxmltree::Document::parse(&text).unwrap();
        let line = document.descendants().find(|n| n.has_tag_name("polyline")).unwrap();
        assert_eq!(line.attribute("points"), Some("64.0,236.0 202.0,136.0 340.0,36.0"));
    }

    #[test]
    fn charts_without_points_or_with_odd_ones_are_drawn() {
        for points in [&[][..], &[(1.0, 0.0)], &[(0.0, 1.0), (2.0, f64::NAN), (3.0, f64::INFINITY)]] {
            let text = svg("", &[chart(points)]);
            roxmltree::Document::parse(&text).unwrap();
            assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
        }
        assert!(svg("", &[]).contains("</svg>"));
    }

    #[test]
    fn ticks_are_round_and_numbers_short() {
        for (least, step) in [(0.7, 1.0), (1.0, 1.0), (13.0, 20.0), (60.0, 100.0), (0.03, 0.05)] {
            assert!((round_step(least) / step - 1.0).abs() < 1e-9, "{least}");
        }
        for (value, text) in [
            (0.0, "0"),
            (0.005, "0.005"),
            (0.025, "0.025"),
            (0.5, "0.5"),
            (64.0, "64"),
            (16384.0, "16384"),
            (2.5e5, "250 k"),
            (1e6, "1 M"),
        ] {
            assert_eq!(short(value), text);
        }
    }
}
