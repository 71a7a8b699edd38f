# SPDX-License-Identifier: MIT
"""The certificate of a scenario: predictions of theory and of linearised closed loops.

It is computed before the scenario is sailed. `motion` and `reference`: the motion of the virtual
leader. `small_gain` and `floquet`: the paper's formulas and its periodic system. `slots` and
`thrust`: the demands of each boat's slot on its propellers. `fleet`, `loop`, `monodromy`,
`sampled`: the boats' sampled closed loops. `gains`, `search`, `noise`: their decay as a function of
the gains, and the cost of higher gains. `probe`, `chain`, `margins`, `agreement`: the greatest
depth of a chain of boats. `certificate`: all results together. `verdict`, `notes`, `report`,
`report_search`, `picture`, `gain_picture`, `files`: their presentation.
"""
