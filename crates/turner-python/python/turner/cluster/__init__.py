"""Pictures and datasets on many machines, by engines that exist: `turner.cluster.dask` and `turner.cluster.ray`.

    from turner.cluster import dask

    out = dask.render(scene, 4096, client="tcp://scheduler:8786", folder="/shared/films")

A picture is split into ranges of samples, and by `tiles` into bands. Each task renders one part; the films of parts are
merged in a tree. A part that is rendered twice, late or again has the same bytes, so nothing that happens to workers
changes the picture. `turner farm split` makes the same parts for queues of commands.
"""
