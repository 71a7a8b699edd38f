# SPDX-License-Identifier: MIT
"""The certificate of a scenario: what theory and linearised closed loop say before it is sailed.

`motion` and `reference`: where the virtual leader goes; `small_gain` and `floquet`: the paper's
formulas and its periodic system; `slots` and `thrust`: what each boat's slot asks of its
propellers; `fleet`, `loop`, `monodromy`, `sampled`: the boats' sampled closed loops; `gains`,
`search`, `noise`: their decay against the gains, and what these cost; `probe`, `chain`, `margins`,
`agreement`: how deep a chain of boats may be; `certificate`: all of that
together; `verdict`, `notes`, `report`, `report_search`, `picture`,
`gain_picture`, `files`: the same for people.
"""
