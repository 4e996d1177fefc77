# Start-up file of `./bha shell`: your own settings first, then the workspace's on top of them.
[ ! -f ~/.bashrc ] || . ~/.bashrc
. "$(dirname "${BASH_SOURCE[0]}")/../ros2_ws/install/bha_environment.sh"
PS1="(bha) ${PS1:-\\w\\$ }"
