//! Sets and ordered lists of axes. An axis is its index 0..17 everywhere inside the kernel.

/// The APCI-8008 drives 18 axes at most (design D12).
pub const MAX_AXES: usize = 18;

/// A set of axes, bit n = axis index n.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct AxisSet(pub u32);

impl AxisSet {
    pub const EMPTY: AxisSet = AxisSet(0);

    /// The axes 0..n-1.
    pub const fn first(n: usize) -> Self {
        AxisSet(((1u64 << n) - 1) as u32)
    }
    pub const fn single(axis: usize) -> Self {
        AxisSet(1 << axis)
    }
    pub const fn with(self, axis: usize) -> Self {
        AxisSet(self.0 | 1 << axis)
    }
    pub const fn contains(self, axis: usize) -> bool {
        self.0 >> axis & 1 == 1
    }
    pub const fn contains_all(self, other: AxisSet) -> bool {
        other.0 & !self.0 == 0
    }
    pub const fn intersects(self, other: AxisSet) -> bool {
        self.0 & other.0 != 0
    }
    pub const fn union(self, other: AxisSet) -> Self {
        AxisSet(self.0 | other.0)
    }
    pub const fn without(self, other: AxisSet) -> Self {
        AxisSet(self.0 & !other.0)
    }
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }
    pub const fn len(self) -> usize {
        self.0.count_ones() as usize
    }
    /// Indices in ascending order.
    pub fn iter(self) -> impl Iterator<Item = usize> {
        let mut left = self.0;
        std::iter::from_fn(move || {
            if left == 0 {
                return None;
            }
            let axis = left.trailing_zeros() as usize;
            left &= left - 1;
            Some(axis)
        })
    }
}

impl FromIterator<usize> for AxisSet {
    fn from_iter<I: IntoIterator<Item = usize>>(axes: I) -> Self {
        axes.into_iter().fold(AxisSet::EMPTY, AxisSet::with)
    }
}

/// The AS structure of the manual (4.3.2.1): axes in the order the command names them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct AxisList {
    len: u8,
    index: [u8; MAX_AXES],
    set: AxisSet,
}

impl AxisList {
    /// # Panics
    /// With more than 18 axes; callers check the machine first.
    pub fn new(axes: &[usize]) -> Self {
        assert!(axes.len() <= MAX_AXES, "more than {MAX_AXES} axes");
        let set = axes.iter().copied().collect();
        let mut list = AxisList { len: axes.len() as u8, set, ..Self::default() };
        for (slot, &axis) in list.index.iter_mut().zip(axes) {
            *slot = axis as u8;
        }
        list
    }
    pub fn len(&self) -> usize {
        self.len as usize
    }
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }
    pub fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        self.index[..self.len()].iter().map(|&a| a as usize)
    }
    pub fn at(&self, position: usize) -> usize {
        self.index[..self.len()][position] as usize
    }
    /// Position of an axis in the list.
    pub fn position(&self, axis: usize) -> Option<usize> {
        self.iter().position(|a| a == axis)
    }
    pub fn set(&self) -> AxisSet {
        self.set
    }
    /// True if an axis stands in the list more than once (ErrorReg bit 0, errAxDef).
    pub fn has_duplicates(&self) -> bool {
        self.set().len() != self.len()
    }
}
