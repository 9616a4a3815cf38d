"""The production line of a program: selection over all pieces of a path, then stretch by stretch plan and proof.

Nothing of it grows with the length of the path but what the caller keeps. Planning goes in order, because every
stretch begins where the one before ended; writing and proving are left to as many processes as there are.
"""

from dataclasses import dataclass, replace

import numpy as np

from mathpost.errors import MathpostError
from mathpost.post import cl as cldata
from mathpost.post import program, selection
from mathpost.post.singularity import regions, states_feed
from mathpost.post.stretch import Planned, Proved, Stretch, plan, prove

LEAD = 2  # records before a stretch: where it begins, and the slope there


@dataclass(frozen=True)
class Made:
    """A stretch of the program that is done."""

    stretch: Stretch
    planned: Planned
    proved: Proved


def produce(setting, pieces, workers, *, store=None, blocks=True, progress=None):
    """Yield the program in stretches, as `Made`, each proved.

    Parameters
    ----------
    setting : mathpost.post.setting.Setting
    pieces : sequence of CLData
        The whole path, in consecutive pieces.
    workers : mathpost.post.workers.Workers
        Who write and prove; what they share is the setting.
    store : optional
        Where the selection keeps what it needs on its way back; see `mathpost.post.selection.choose_pieces`.
    blocks : bool
        Whether `Proved.blocks` are wanted.
    progress : callable, optional
        Called with the number of records that the selection has gone through.

    Raises
    ------
    ReachError, InputError
        See `mathpost.post.postprocess.run`.
    """
    chosen = selection.choose_pieces(
        setting.kin,
        pieces,
        setting.strategy,
        start=setting.start,
        split=setting.split,
        prefer=setting.prefer,
        store=store,
        progress=progress,
    )
    ended = None
    jobs = _planned(setting, _stretches(setting, pieces, chosen))
    for (stretch, planned, begun), proved in workers.map(_prove if blocks else _prove_text, jobs):
        # What was taken to hold at the beginning must be what the text before has left behind.
        if ended not in (None, begun):
            raise MathpostError(f"{planned.cl.where(0)}: the program does not go on where it ended")
        ended = proved.state
        yield Made(stretch, planned, proved)


def _stretches(setting, pieces, chosen):
    """Put the records that belong together into stretches: a region that needs a way lies in one as a whole."""
    whole_regions = setting.singular != "direct" or setting.compare
    always = setting.cone is not None or not any(map(states_feed, pieces))
    cl, joints, lead, breaks, cost, first_branch = None, np.empty((0, 5)), 0, [], 0.0, 0
    for number, selected in enumerate(chosen):
        breaks += [len(joints) + record for record in selected.breaks]
        cl = cldata.join([cl, pieces[number]]) if cl else pieces[number]
        joints = np.concatenate([joints.T, selected.joints.T], axis=1).T  # joint by joint in memory
        cost, first_branch = cost + selected.cost, first_branch + int((selected.branch == 0).sum())
        found = regions(setting.kin, cl, joints, cone=setting.cone) if always or states_feed(cl) else []
        last = number == len(pieces) - 1
        if whole_regions and not last and found and found[-1][1] == len(cl) - 1:
            continue
        own = tuple(region for region in found if region[1] >= max(lead, 1))
        yield Stretch(cl, joints, lead, own, tuple(breaks), cost, first_branch, last)
        lead, breaks, cost, first_branch = min(LEAD, len(cl)), [], 0.0, 0
        cl, joints = cl.part(len(cl) - lead, len(cl)), joints[-lead:]


def _planned(setting, stretches):
    """Yield each stretch with its plan and the state that its text begins with, and what `_prove` is sent."""
    writer, state = setting.writer(), None
    writer.head()
    for stretch in stretches:
        planned, begun = plan(setting, stretch), program.reader_at(writer).state
        writer.skip(planned.blocks)
        yield (stretch, planned, begun), (planned, state, writer.foot() if stretch.last else "")
        state = writer.state


def _prove(setting, job):
    planned, state, foot = job
    return prove(setting, planned, state=state, foot=foot)


def _prove_text(setting, job):
    """The same without the blocks, which need not come back from another process."""
    return replace(_prove(setting, job), blocks=None)
