//! The picture, as the paper's Figure 11 has it: every path in one field.

use crate::output::Curve;
use crate::robot::signals::chassis;
use crate::robot::vector::Vector;
use crate::robot::world::{GOAL, OBSTACLE, OBSTACLE_RADIUS};
use std::fmt::{self, Write as _};

/// Told apart by colour-blind readers; the shapes of the points tell them apart in black and white.
const COLOURS: [&str; 7] = ["#0072b2", "#d55e00", "#009e73", "#a0408a", "#b07800", "#2f8fc8", "#333333"];

const WIDTH: f64 = 820.0;
const LEFT: f64 = 70.0;
const TOP: f64 = 52.0;
const LEGEND: f64 = 176.0;
const BOTTOM: f64 = 62.0;

pub(crate) fn svg(curves: &[Curve], title: &str) -> String {
    let mut svg = String::new();
    // Nothing fails that is written to a string.
    let _ = Field::around(curves).draw(&mut svg, curves, title);
    svg
}

/// The part of the plane that is shown, and its scale in pixels per metre.
struct Field {
    from: Vector,
    to: Vector,
    scale: f64,
}

impl Field {
    const GRID: f64 = 0.5;

    fn around(curves: &[Curve]) -> Self {
        let reach = OBSTACLE_RADIUS + chassis::RADIUS;
        let border = Vector::new(reach, reach);
        let fixed = [Vector::default(), GOAL, OBSTACLE - border, OBSTACLE + border];
        let points = || fixed.iter().chain(curves.iter().flat_map(|curve| &curve.path));
        let least = |of: fn(&Vector) -> f64| points().map(of).fold(0.0, f64::min) - 0.25;
        let most = |of: fn(&Vector) -> f64| points().map(of).fold(0.0, f64::max) + 0.25;
        let from = Vector::new(least(|point| point.x), least(|point| point.y));
        let to = Vector::new(most(|point| point.x), most(|point| point.y));
        Self { from, to, scale: WIDTH / (to.x - from.x) }
    }

    fn x(&self, metres: f64) -> f64 {
        LEFT + (metres - self.from.x) * self.scale
    }

    fn y(&self, metres: f64) -> f64 {
        TOP + (self.to.y - metres) * self.scale
    }

    fn height(&self) -> f64 {
        (self.to.y - self.from.y) * self.scale
    }

    fn draw(&self, svg: &mut String, curves: &[Curve], title: &str) -> fmt::Result {
        let width = LEFT + WIDTH + LEGEND;
        let height = (TOP + self.height() + BOTTOM).max(TOP + 150.0 + 22.0 * curves.len() as f64);
        writeln!(
            svg,
            "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {width:.0} {height:.0}' width='{width:.0}' \
             height='{height:.0}' font-family='Helvetica, Arial, sans-serif' font-size='15' fill='#111'>\n\
             <title>{title}</title>\n\
             <defs><pattern id='hatch' width='7' height='7' patternUnits='userSpaceOnUse' \
             patternTransform='rotate(45)'><rect width='7' height='7' fill='#e4e4e4'/>\
             <path d='M0 0V7' stroke='#9a9a9a' stroke-width='2'/></pattern></defs>\n\
             <rect width='100%' height='100%' fill='white'/>\n\
             <text x='{LEFT}' y='30' font-size='18'>{title}</text>"
        )?;
        self.draw_axes(svg)?;
        self.draw_obstacle(svg)?;
        for (at, curve) in curves.iter().enumerate() {
            self.draw_curve(svg, &curve.path, at)?;
        }
        self.draw_ends(svg)?;
        draw_legend(svg, curves)?;
        svg.write_str("</svg>\n")
    }

    fn draw_axes(&self, svg: &mut String) -> fmt::Result {
        let (left, right) = (self.x(self.from.x), self.x(self.to.x));
        let (top, bottom) = (self.y(self.to.y), self.y(self.from.y));
        for x in ticks(self.from.x, self.to.x) {
            let at = self.x(x);
            writeln!(
                svg,
                "<path d='M{at:.1} {top:.1}V{bottom:.1}' stroke='#e2e2e2'/>\
                 <path d='M{at:.1} {bottom:.1}v6' stroke='#111'/>\
                 <text x='{at:.1}' y='{:.1}' text-anchor='middle'>{}</text>",
                bottom + 22.0,
                number(x)
            )?;
        }
        for y in ticks(self.from.y, self.to.y) {
            let at = self.y(y);
            writeln!(
                svg,
                "<path d='M{left:.1} {at:.1}H{right:.1}' stroke='#e2e2e2'/>\
                 <path d='M{left:.1} {at:.1}h-6' stroke='#111'/>\
                 <text x='{:.1}' y='{:.1}' text-anchor='end'>{}</text>",
                left - 10.0,
                at + 5.0,
                number(y)
            )?;
        }
        let (middle, centre) = ((left + right) / 2.0, (top + bottom) / 2.0);
        writeln!(
            svg,
            "<rect x='{left:.1}' y='{top:.1}' width='{:.1}' height='{:.1}' fill='none' stroke='#111'/>\n\
             <text x='{middle:.1}' y='{:.1}' text-anchor='middle'>x [m]</text>\n\
             <text transform='translate(20 {centre:.1}) rotate(-90)' text-anchor='middle'>y [m]</text>",
            right - left,
            bottom - top,
            bottom + 48.0
        )
    }

    fn draw_obstacle(&self, svg: &mut String) -> fmt::Result {
        let (x, y) = (self.x(OBSTACLE.x), self.y(OBSTACLE.y));
        let radius = OBSTACLE_RADIUS * self.scale;
        let touched = (OBSTACLE_RADIUS + chassis::RADIUS) * self.scale;
        writeln!(
            svg,
            "<circle cx='{x:.1}' cy='{y:.1}' r='{radius:.1}' fill='url(#hatch)' stroke='#444' stroke-width='1.5'/>\n\
             <circle cx='{x:.1}' cy='{y:.1}' r='{touched:.1}' fill='none' stroke='#444' stroke-dasharray='6 4'/>\n\
             <text x='{x:.1}' y='{:.1}' text-anchor='middle' stroke='white' stroke-width='5' \
             paint-order='stroke'>obstacle</text>",
            y + radius * 0.55
        )
    }

    fn draw_curve(&self, svg: &mut String, path: &[Vector], number: usize) -> fmt::Result {
        write!(svg, "<g stroke='{0}' fill='{0}'><polyline fill='none' stroke-width='1.3' points='", colour(number))?;
        for point in path {
            write!(svg, "{:.1},{:.1} ", self.x(point.x), self.y(point.y))?;
        }
        svg.write_str("'/><path stroke='none' d='")?;
        for point in path {
            draw_point(svg, self.x(point.x), self.y(point.y), number)?;
        }
        svg.write_str("'/></g>\n")
    }

    fn draw_ends(&self, svg: &mut String) -> fmt::Result {
        for (place, name) in [(Vector::default(), "start"), (GOAL, "goal")] {
            let (x, y) = (self.x(place.x), self.y(place.y));
            // A cross for the start, a ring with a cross for the goal.
            let ring = if name == "goal" { 9.0 } else { 0.0 };
            writeln!(
                svg,
                "<g stroke='#111' stroke-width='2.2' fill='none'><circle cx='{x:.1}' cy='{y:.1}' r='{ring}'/>\
                 <path d='M{x:.1} {y:.1}m-9 0h18m-9 -9v18'/></g>\
                 <text x='{x:.1}' y='{:.1}' text-anchor='middle' font-weight='bold'>{name}</text>",
                y + 28.0
            )?;
        }
        Ok(())
    }
}

fn draw_legend(svg: &mut String, curves: &[Curve]) -> fmt::Result {
    let left = LEFT + WIDTH + 22.0;
    writeln!(svg, "<text x='{left}' y='{}' font-weight='bold'>intensity</text>", TOP + 14.0)?;
    for (at, curve) in curves.iter().enumerate() {
        let y = TOP + 38.0 + 22.0 * at as f64;
        write!(svg, "<g stroke='{0}' fill='{0}'><path d='M{left} {y}h36' stroke-width='1.3'/>", colour(at))?;
        svg.write_str("<path stroke='none' d='")?;
        draw_point(svg, left + 10.0, y, at)?;
        draw_point(svg, left + 26.0, y, at)?;
        writeln!(svg, "'/></g><text x='{}' y='{}'>{}</text>", left + 48.0, y + 5.0, curve.intensity)?;
    }
    let y = TOP + 56.0 + 22.0 * curves.len() as f64;
    writeln!(
        svg,
        "<path d='M{left} {y}h36' stroke='#444' stroke-dasharray='6 4'/>\
         <text x='{0}' y='{1}' font-size='13'>inside, the</text>\
         <text x='{0}' y='{2}' font-size='13'>robot touches</text>\
         <text x='{0}' y='{3}' font-size='13'>the obstacle</text>",
        left + 48.0,
        y + 4.0,
        y + 20.0,
        y + 36.0
    )
}

/// A disc, a square, a triangle, a diamond, or a triangle on its head, as part of a path.
fn draw_point(svg: &mut String, x: f64, y: f64, number: usize) -> fmt::Result {
    let shape = match number % 5 {
        0 => "m-2.8 0a2.8 2.8 0 1 0 5.6 0a2.8 2.8 0 1 0 -5.6 0z",
        1 => "m-2.5 -2.5h5v5h-5z",
        2 => "m0 -3.4l3.2 5.6h-6.4z",
        3 => "m0 -3.7l3.7 3.7l-3.7 3.7l-3.7 -3.7z",
        _ => "m0 3.4l3.2 -5.6h-6.4z",
    };
    write!(svg, "M{x:.1} {y:.1}{shape}")
}

/// With a minus that is as wide as a plus.
fn number(metres: f64) -> String {
    format!("{metres:.1}").replace('-', "−")
}

fn colour(number: usize) -> &'static str {
    COLOURS[number % COLOURS.len()]
}

/// The multiples of the grid from one place to another.
fn ticks(from: f64, to: f64) -> impl Iterator<Item = f64> {
    let (first, last) = ((from / Field::GRID).ceil() as i32, (to / Field::GRID).floor() as i32);
    (first..=last).map(|at| f64::from(at) * Field::GRID)
}
