//! The four CNC tasks (chapter 3.2.1): the virtual machine that executes autocode.
