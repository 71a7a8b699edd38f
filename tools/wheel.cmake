# SPDX-License-Identifier: MIT
# Contents of a wheel in addition to the native module and the Python tree: flotillad, and Chart.js.
if(TARGET flotillad)
  install(TARGETS flotillad DESTINATION flotilla_usv/tree/bin)
endif()
find_file(CHART_JS chart.min.js PATHS /usr/share/javascript/chart.js)
if(NOT CHART_JS)
  message(FATAL_ERROR "no chart.min.js: apt-get install libjs-chart.js, or name one with "
    "--config-settings cmake.define.CHART_JS=FILE")
endif()
install(FILES ${CHART_JS} DESTINATION flotilla_usv/tree/sil/view/page)
