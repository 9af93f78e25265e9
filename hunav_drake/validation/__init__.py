"""Cases that tell how well models of human motion walk like people."""
