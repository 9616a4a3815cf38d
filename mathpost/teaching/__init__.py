"""What a class needs: exercises, pictures, marking, and the check of spreadsheets.

Read `course` first (exercises, and the views of the lessons), then `draw` (machines that move in a browser),
`workbook` (which cell of a spreadsheet is wrong) and `classroom` (marking a class), which works within
`bounds` of time and memory.
Nobody who posts programs needs these rooms.
"""
