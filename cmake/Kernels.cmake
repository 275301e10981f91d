# Embeds kernels/*.k; see boxunion_add_kernels.
function(boxunion_add_kernels target)
endfunction()
