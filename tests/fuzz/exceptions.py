"""Entries that are not tried with bad arguments, and cases that may end otherwise; each with the reason."""

RECORDS = """
chain.Inertias codegen.ecmascript.Exported codegen.pose.Kinematics codegen.recorded_functions.Recorded
codegen.tape.Recording crane.JointForces crane.LoadResponse crane.Posture crane.Reach crane.Sag
crane.positioning.AngleNetworkSag crane.positioning.Errors crane.positioning.Placement
crane.positioning.TableSag crane.positioning.TrigonometricSag crane.positioning.export.Networks
crane.shape.Bars crane.shape.NodalResponse docking.Docking docking.Solutions indices.Closed indices.Ellipsoid
indices.Measure indices.Situation indices.Spectral indices.Symbols inverse_kinematics.SeedsEnded
inverse_kinematics.Solutions networks.Learned networks.baselines.Polynomial networks.baselines.Trees
networks.comparison.Times networks.design.Design networks.design.RadialBasisDesign networks.design.Trial
networks.domain.Answer networks.growth.Growth networks.ladder.Candidate networks.ladder.Climbed
networks.ladder.Task networks.levenberg_marquardt.Training networks.normal_equations.Layout
networks.normal_equations.TrainingSet networks.pruning.Pruning networks.rounding.Rounding
networks.validation.AcceptanceBias networks.validation.ErrorDistribution networks.worst_case.WorstCase
operations.Operations reach.Path reach.Placement reach.Placements robots.Description robots.Vehicle
sampling.DataSets scenes.Body scenes.Slider search.Extreme search.Extremes search.GeneticSearch
search.ZoomSearch symbolic.Derivation symbolic.SymbolicChain tasks.Effect tasks.Ranking timing.Machine
timing.Ratio timing.Way urdf.Model urdf.SerialPath workspace.compiled.Solution
workspace.dataset.ConfidenceData workspace.dataset.JacobianData workspace.dataset.Samples
workspace.dataset.Scaling workspace.dynamics.DynamicParameters workspace.export.Confidence
workspace.export.Layer workspace.jacobian_net.Estimate workspace.maps.Map workspace.maps.Reply
workspace.maps.Survey workspace.reachability.Branch workspace.reachability.Frames
workspace.resolved_rate.Tracking workspace.resolved_rate.Wanted workspace.training.Epoch
workspace.training.Loss workspace.training.Rows workspace.training.Training
"""
"""Records, which hold what a function made: whoever takes one looks at what is in it."""

ENTRIES = {
    "a step inside the package, with what an entry in front of it has checked": """
        chain.Inertias.merged chain.Inertias.moved codegen.tape.Tape.apply codegen.tape.Tape.constant
        codegen.tape.Tape.input codegen.tape.Tape.solve codegen.tape.Tape.value crane.shape.displacements
        docking.Docking.at indices.Closed.too_large networks.FeedForward.answer networks.Network.answer
        networks.View.checked networks.View.seen networks.RadialBasis.answer networks.RadialBasis.hidden
        networks.normal_equations.Layout.layers
        networks.normal_equations.Layout.of networks.normal_equations.Layout.pack
        networks.normal_equations.Layout.unpacked networks.normal_equations.TrainingSet.of
        networks.normal_equations.TrainingSet.pieces networks.normal_equations.normal_equations
        networks.normal_equations.sum_of_squares scenes.Scene.html_with symbolic.CompiledIndex
        symbolic.CompiledIndex.plain_gradient workspace.dataset.Samples.rows workspace.dataset.Scaling.apply
        workspace.dataset.Scaling.undo workspace.dynamics.DynamicParameters.rows
        workspace.jacobian_net.JacobianNet.draw_from workspace.jacobian_net.decode
        workspace.jacobian_net.encode workspace.reachability.in_tool_axes""",
    "a check itself, of a tensor that has come through to_float64": """
        spatial.are_readable spatial.common_batch spatial.value_and_gradient
        spatial.require_finite_result spatial.require_joints
        workspace.archive.require_like""",
    "an answer to tensors of poses, times or strokes, which the function that it is given to makes": """
        crane.positioning.AngleNetworkSag.__call__ crane.positioning.TableSag.__call__
        crane.positioning.TrigonometricSag.__call__ workspace.maps.ByBranches.__call__
        workspace.maps.ByClosedForm.__call__ workspace.maps.ByNetwork.__call__
        workspace.resolved_rate.Circle.__call__""",
    "any entries are taken, by name": "networks.Card.with_entries",
    "made by reach.survey; reach.ReachMap.load refuses files that do not fit": "reach.ReachMap",
    "needs a compiler and an emulator, seconds each": "timing.instructions.instructions_per_configuration",
    "descends on trained networks, seconds each": "crane.positioning.export.javascript_module",
}

CASES = {
    r"spatial\.wrap_to_pi\(angle: with nan": "a NaN is documented to stay one",
    r"inverse_kinematics\.null_space_step\(objective: a class": "a class can be called",
    r"spatial\.(to_\w+|require_\w+|batch_of)\((name|shape)": "the package's own words; each call would pay",
    r"networks\.comparison\.times\((rounds|seconds): (numpy|a tensor)": "times differ",
    r"sampling\.Box\.from_chain\(levels: a list": "None is a level: not a grid",
    r"sampling\.uvms_space\(half_range_deg: 1e\+300": "the number of steps is named",
    r"sampling\.uvms_space\(index_name": "it is the name of an index, as the error says",
    r"tasks\.rank\(joint_rates": "rates of nothing hold all joints, and so the index is zero, which is said",
    r"timing\.(conditions|versions)\(distributions": "importlib's own error names what is not installed",
    r"timing\.measure\((rounds|seconds): (numpy|a tensor)": "times differ",
    r"workspace\.archive\.read_archive\(kind": "the file is said to be of another kind",
    r"networks\.judge_again\(\w+: numpy": "times on the card differ",
    r"networks\.load\(path": "the error says that it names no file",
    r"(networks\.growth\.fit|reach\.survey)\(\w+: huge": "what overflows is named",
    r"networks\.card_text\.percent": "whatever a card holds is written",
    r"symbolic\.compile_index\(index: text": "the name of an index is named",
}
"""Cases by patterns of what they print."""
