//! A height map that tools cut: the lower surface of a tool that is swept along a straight move, exact at every node.

/// Lower surface of a tool about its axis: flat out to `radius - corner`, then a quarter circle of radius `corner`.
/// Corner 0 is a flat end mill, corner = radius a ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    pub radius: f64,
    pub corner: f64,
}

/// A move of the tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    pub from: [f64; 3],
    pub to: [f64; 3],
}

/// What is looked at on a move beside the cut.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Watch {
    /// On a rapid: the tool smaller by so much on all sides must meet nothing, mm.
    pub margin: Option<f64>,
    /// Shank and holder: radius, height of the lower face above the tip.
    pub bodies: Vec<(f64, f64)>,
}

/// What the tool cut, what it met as a rapid, and what shank or holder met (the body that met most).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Passed {
    pub cut: Met,
    pub rapid: Met,
    pub body: Met,
    pub which: usize,
}

/// What a move met: most height above the tool's lower surface, mm, where, and the volume above it, mm3.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Met {
    pub depth: f64,
    pub at: [f64; 2],
    pub volume: f64,
}

/// Heights at the middles of square cells, row by row from the least y. A node that nothing covers is -infinity.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightMap {
    pub x0: f64,
    pub y0: f64,
    pub step: f64,
    pub nx: usize,
    pub ny: usize,
    pub z: Vec<f64>,
    /// Source line of the move that lowered a node last, 0 where none did.
    pub line: Vec<u32>,
    /// Underside of the body: nothing is cut below.
    pub floor: f64,
    tiles_x: usize,
    /// No node of a tile is higher.
    tile_max: Vec<f64>,
}

/// Nodes of a tile along each side.
const TILE: usize = 16;
/// A node this near to the rim of the tool, mm, is beside it: rounding must not decide.
const RIM: f64 = 1e-9;
/// Longer moves are cut up, so that the box around a slanting one does not hold the whole map.
const PIECE_RADII: f64 = 6.0;
/// A bull nose on a move that climbs less, mm, is taken at its lower end: as much too deep at most.
const LEVEL_MM: f64 = 1e-4;

impl HeightMap {
    /// `z` has nx * ny heights; the first node lies at (x0 + step / 2, y0 + step / 2).
    pub fn new(x0: f64, y0: f64, step: f64, nx: usize, z: Vec<f64>) -> HeightMap {
        let ny = z.len().checked_div(nx).unwrap_or(0);
        let (tiles_x, tiles_y) = (nx.div_ceil(TILE), ny.div_ceil(TILE));
        let line = vec![0; z.len()];
        let tile_max = vec![f64::NEG_INFINITY; tiles_x * tiles_y];
        let mut map = HeightMap { x0, y0, step, nx, ny, z, line, floor: f64::NEG_INFINITY, tiles_x, tile_max };
        (0..map.tile_max.len()).for_each(|tile| map.measure(tile));
        map
    }

    fn measure(&mut self, tile: usize) {
        let (i0, j0) = (tile % self.tiles_x * TILE, tile / self.tiles_x * TILE);
        let (i1, j1) = ((i0 + TILE).min(self.nx), (j0 + TILE).min(self.ny));
        let rows = (j0..j1).flat_map(|j| &self.z[j * self.nx + i0..j * self.nx + i1]);
        self.tile_max[tile] = rows.copied().fold(f64::NEG_INFINITY, f64::max);
    }

    fn x(&self, i: usize) -> f64 {
        self.x0 + (i as f64 + 0.5) * self.step
    }
    fn y(&self, j: usize) -> f64 {
        self.y0 + (j as f64 + 0.5) * self.step
    }

    /// Cuts a move; what it drives through at rapid is looked at before, what shank and holder meet afterwards.
    pub fn pass(&mut self, tool: Profile, m: Move, line: u32, watch: &Watch) -> Passed {
        let mut passed = Passed::default();
        if let Some(margin) = watch.margin.filter(|margin| *margin < tool.radius) {
            let radius = tool.radius - margin;
            let smaller = Profile { radius, corner: tool.corner.min(radius) };
            passed.rapid = self.probe(smaller, m.raised(margin));
        }
        passed.cut = self.cut(tool, m, line);
        for (which, (radius, height)) in watch.bodies.iter().enumerate() {
            let met = self.probe(Profile { radius: *radius, corner: 0.0 }, m.raised(*height));
            if met.depth > passed.body.depth {
                (passed.body, passed.which) = (met, which);
            }
        }
        passed
    }

    /// Lowers the map to what a tool leaves on a move, and tells what was in its way.
    pub fn cut(&mut self, tool: Profile, m: Move, line: u32) -> Met {
        let mut met = Met::default();
        for piece in pieces(m, tool) {
            let sweep = Sweep::new(tool, piece);
            for tile in self.tiles(&sweep) {
                if self.cut_tile(tile, &sweep, line, &mut met) {
                    self.measure(tile);
                }
            }
        }
        met.volume *= self.step * self.step;
        met
    }

    fn cut_tile(&mut self, tile: usize, sweep: &Sweep, line: u32, met: &mut Met) -> bool {
        let mut lowered = false;
        let (columns, rows) = self.nodes(tile, sweep);
        for j in rows {
            let y = self.y(j);
            for i in columns.clone() {
                let at = j * self.nx + i;
                let before = self.z[at];
                if before <= sweep.lowest {
                    continue;
                }
                let x = self.x(i);
                let depth = before - sweep.height(x, y).max(self.floor);
                if depth > 0.0 {
                    (self.z[at], self.line[at]) = (before - depth, line);
                    lowered = true;
                    met.add(depth, x, y);
                }
            }
        }
        lowered
    }

    /// What a body meets on a move; nothing is cut.
    pub fn probe(&self, body: Profile, m: Move) -> Met {
        let mut met = Met::default();
        for piece in pieces(m, body) {
            let sweep = Sweep::new(body, piece);
            for tile in self.tiles(&sweep) {
                let (columns, rows) = self.nodes(tile, &sweep);
                for (i, j) in rows.flat_map(|j| columns.clone().map(move |i| (i, j))) {
                    let before = self.z[j * self.nx + i];
                    if before > sweep.lowest {
                        let (x, y) = (self.x(i), self.y(j));
                        met.add(before - sweep.height(x, y), x, y);
                    }
                }
            }
        }
        met.volume *= self.step * self.step;
        met
    }

    /// Tiles below a sweep that have a node above its lowest point.
    fn tiles(&self, sweep: &Sweep) -> Vec<usize> {
        let ((i0, i1), (j0, j1)) = (self.columns(sweep), self.rows(sweep));
        if i0 >= i1 || j0 >= j1 {
            return Vec::new();
        }
        let across = i0 / TILE..=(i1 - 1) / TILE;
        let tiles = (j0 / TILE..=(j1 - 1) / TILE).flat_map(|b| across.clone().map(move |a| b * self.tiles_x + a));
        tiles.filter(|t| self.tile_max[*t] > sweep.lowest).collect()
    }

    fn nodes(&self, tile: usize, sweep: &Sweep) -> (std::ops::Range<usize>, std::ops::Range<usize>) {
        let ((i0, i1), (j0, j1)) = (self.columns(sweep), self.rows(sweep));
        let (a, b) = (tile % self.tiles_x * TILE, tile / self.tiles_x * TILE);
        (i0.max(a)..i1.min(a + TILE), j0.max(b)..j1.min(b + TILE))
    }

    fn columns(&self, sweep: &Sweep) -> (usize, usize) {
        range(sweep.low[0] - self.x0, sweep.high[0] - self.x0, self.step, self.nx)
    }
    fn rows(&self, sweep: &Sweep) -> (usize, usize) {
        range(sweep.low[1] - self.y0, sweep.high[1] - self.y0, self.step, self.ny)
    }

    /// Raises the map to a triangle. With `grow` 0 its height counts at the nodes inside; else at all nodes not
    /// farther than that from it (seen from above), so that no thin wall falls between them.
    pub fn raise(&mut self, triangle: [[f64; 3]; 3], grow: f64) {
        let [a, b, c] = triangle;
        let bound = |k: usize, f: fn(f64, f64) -> f64| f(f(a[k], b[k]), c[k]);
        let (i0, i1) =
            range(bound(0, f64::min) - grow - self.x0, bound(0, f64::max) + grow - self.x0, self.step, self.nx);
        let (j0, j1) =
            range(bound(1, f64::min) - grow - self.y0, bound(1, f64::max) + grow - self.y0, self.step, self.ny);
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        for (j, i) in (j0..j1).flat_map(|j| (i0..i1).map(move |i| (j, i))) {
            let (x, y) = (self.x(i), self.y(j));
            let mut z = inside(&triangle, area, x, y);
            if grow > 0.0 && z == f64::NEG_INFINITY {
                let edges = [(a, b), (b, c), (c, a)].map(|(from, to)| near_edge(from, to, x, y, grow));
                z = edges.into_iter().fold(z, f64::max);
            }
            let at = j * self.nx + i;
            self.z[at] = self.z[at].max(z);
        }
    }

    /// Measures the tiles again, after [`HeightMap::raise`].
    pub fn settle(&mut self) {
        (0..self.tile_max.len()).for_each(|tile| self.measure(tile));
    }
}

impl Move {
    fn raised(mut self, by: f64) -> Move {
        self.from[2] += by;
        self.to[2] += by;
        self
    }
}

impl Met {
    fn add(&mut self, depth: f64, x: f64, y: f64) {
        if depth > 0.0 {
            self.volume += depth;
            if depth > self.depth {
                (self.depth, self.at) = (depth, [x, y]);
            }
        }
    }
}

/// Nodes between two coordinates, as far as there are any.
fn range(low: f64, high: f64, step: f64, count: usize) -> (usize, usize) {
    let first = (low / step - 0.5).ceil().clamp(0.0, count as f64) as usize;
    let behind = ((high / step - 0.5).floor() + 1.0).clamp(0.0, count as f64) as usize;
    (first, behind)
}

fn inside(t: &[[f64; 3]; 3], area: f64, x: f64, y: f64) -> f64 {
    if area == 0.0 {
        return f64::NEG_INFINITY;
    }
    let part = |p: [f64; 3], q: [f64; 3]| ((p[0] - x) * (q[1] - y) - (q[0] - x) * (p[1] - y)) / area;
    let (u, v, w) = (part(t[1], t[2]), part(t[2], t[0]), part(t[0], t[1]));
    // a node on the edge between two triangles belongs to both
    if u.min(v).min(w) < -1e-12 { f64::NEG_INFINITY } else { u * t[0][2] + v * t[1][2] + w * t[2][2] }
}

fn near_edge(from: [f64; 3], to: [f64; 3], x: f64, y: f64, grow: f64) -> f64 {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let square = dx * dx + dy * dy;
    if square == 0.0 {
        let near = (x - from[0]).hypot(y - from[1]) <= grow;
        return if near { from[2].max(to[2]) } else { f64::NEG_INFINITY };
    }
    let t = (((x - from[0]) * dx + (y - from[1]) * dy) / square).clamp(0.0, 1.0);
    let near = (x - from[0] - t * dx).hypot(y - from[1] - t * dy) <= grow;
    if near { from[2] + t * (to[2] - from[2]) } else { f64::NEG_INFINITY }
}

fn pieces(m: Move, tool: Profile) -> impl Iterator<Item = Move> {
    let along: [f64; 3] = std::array::from_fn(|k| m.to[k] - m.from[k]);
    let count = (along[0].hypot(along[1]) / (PIECE_RADII * tool.radius)).ceil().clamp(1.0, 1e6);
    let point = move |k: f64| std::array::from_fn(|a| m.from[a] + along[a] * (k / count));
    (0..count as usize).map(move |k| Move { from: point(k as f64), to: point(k as f64 + 1.0) })
}

/// A tool on a straight move.
struct Sweep {
    tool: Profile,
    from: [f64; 3],
    along: [f64; 3],
    /// Length of the move seen from above, and its square.
    length: f64,
    length2: f64,
    low: [f64; 2],
    high: [f64; 2],
    lowest: f64,
}

impl Sweep {
    fn new(tool: Profile, m: Move) -> Sweep {
        let along: [f64; 3] = std::array::from_fn(|k| m.to[k] - m.from[k]);
        let length2 = along[0] * along[0] + along[1] * along[1];
        Sweep {
            tool,
            from: m.from,
            along,
            length: length2.sqrt(),
            length2,
            low: std::array::from_fn(|k| m.from[k].min(m.to[k]) - tool.radius),
            high: std::array::from_fn(|k| m.from[k].max(m.to[k]) + tool.radius),
            lowest: m.from[2].min(m.to[2]),
        }
    }

    /// Lowest height of the tool's surface over a place during the move; infinity where the tool does not come.
    #[inline]
    fn height(&self, x: f64, y: f64) -> f64 {
        let (px, py) = (x - self.from[0], y - self.from[1]);
        let rim = self.tool.radius - RIM;
        if self.length2 == 0.0 {
            let r2 = px * px + py * py;
            return if r2 <= rim * rim { self.lowest + self.rise(r2.sqrt()) } else { f64::INFINITY };
        }
        // the tool's axis is nearest to the place at t0, q from it
        let t0 = (px * self.along[0] + py * self.along[1]) / self.length2;
        let across = (px * self.along[1] - py * self.along[0]) / self.length;
        let reach2 = rim * rim - across * across;
        if reach2 < 0.0 {
            return f64::INFINITY;
        }
        let reach = reach2.sqrt() / self.length;
        let (first, last) = ((t0 - reach).max(0.0), (t0 + reach).min(1.0));
        if first > last {
            return f64::INFINITY;
        }
        let (dz, corner) = (self.along[2], self.tool.corner);
        if dz == 0.0 || (corner > 0.0 && corner < self.tool.radius && dz.abs() < LEVEL_MM) {
            let t = t0.clamp(first, last);
            return self.lowest + self.rise(self.distance(t - t0, across));
        }
        let t = if corner == 0.0 {
            if dz < 0.0 { last } else { first }
        } else if corner >= self.tool.radius {
            // the sphere touches where its surface is as steep as the move
            let w2 = (self.tool.radius * self.tool.radius - across * across).max(0.0);
            let slope = dz / (self.length * (self.length2 + dz * dz).sqrt());
            (t0 - slope * w2.sqrt()).clamp(first, last)
        } else {
            self.bull(t0, across, first, last)
        };
        self.from[2] + t * dz + self.rise(self.distance(t - t0, across))
    }

    /// Where a torus touches: the height is convex over the move, so its slope changes sign once.
    fn bull(&self, t0: f64, across: f64, mut first: f64, mut last: f64) -> f64 {
        let core = self.tool.radius - self.tool.corner;
        let slope = |t: f64| {
            let r = self.distance(t - t0, across);
            let over = (r - core).max(0.0);
            let steep = over / (self.tool.corner * self.tool.corner - over * over).max(1e-300).sqrt();
            self.along[2] + if r > 0.0 { steep * self.length2 * (t - t0) / r } else { 0.0 }
        };
        for _ in 0..40 {
            let middle = 0.5 * (first + last);
            if slope(middle) < 0.0 {
                first = middle;
            } else {
                last = middle;
            }
        }
        0.5 * (first + last)
    }

    fn distance(&self, t: f64, across: f64) -> f64 {
        (across * across + t * t * self.length2).sqrt()
    }

    /// Height of the tool's surface above its tip at a distance from the axis.
    fn rise(&self, r: f64) -> f64 {
        let corner = self.tool.corner;
        let over = r - (self.tool.radius - corner);
        if over <= 0.0 { 0.0 } else { corner - (corner * corner - over * over).max(0.0).sqrt() }
    }
}
