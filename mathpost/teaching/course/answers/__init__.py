"""The kinds of answer to an exercise: a number, an angle, a vector, a pose, a name.

A kind of answer turns the learner's input into plain data (numbers, text, lists of them, as in JSON), decides
whether two answers are the same, and knows the mix-ups that all answers of its kind share: `kind` is what all have
in common, then a file each: `numbers`, `pose`, `names`, `function`. It executes nothing, so a stored answer can be
read again safely.
"""

from mathpost.teaching.course.answers.function import Written as Written
from mathpost.teaching.course.answers.kind import Kind as Kind
from mathpost.teaching.course.answers.names import Name as Name
from mathpost.teaching.course.answers.names import Names as Names
from mathpost.teaching.course.answers.numbers import Angle as Angle
from mathpost.teaching.course.answers.numbers import Joints as Joints
from mathpost.teaching.course.answers.numbers import Number as Number
from mathpost.teaching.course.answers.numbers import Vector as Vector
from mathpost.teaching.course.answers.pose import Pose as Pose
