"""One colour per role in every picture, and its style of line; `paths.js` repeats those that it draws."""

# Okabe and Ito's palette: distinct for the colour-blind and, by line style, in grey.
ROLES = {
    "machine": ("#7f7f7f", "-"),
    "workpiece": ("#0072b2", "-"),
    "tool": ("#d55e00", "-"),
    "workpiece side": ("#56b4e9", "-"),
    "tool side": ("#e69f00", "--"),
    "first branch": ("#009e73", "-"),
    "second branch": ("#cc79a7", "--"),
    "published": ("#000000", ":"),
    "optimal": ("#e69f00", "-"),
    "shortest": ("#56b4e9", "-."),
    "paper": ("#000000", ":"),
    "kept": ("#d55e00", "--"),
    "forbidden": ("#f0e442", "-"),
    "direct": ("#332288", "-"),
    "linear": ("#882255", "--"),
    "cubic": ("#44aa99", "-"),
    "cubic lifted": ("#117733", "--"),
    "aside": ("#999933", ":"),
    "retract": ("#aa4499", "-."),
}
COLOUR, STYLE = ({role: look[n] for role, look in ROLES.items()} for n in (0, 1))
