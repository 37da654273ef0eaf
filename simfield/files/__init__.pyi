from .block_folder import block_files as block_files, read_block as read_block, write_block as write_block
from .columns import ALL_FILES as ALL_FILES, TRUTH_FILE as TRUTH_FILE
from .csv_table import BlockFolderError as BlockFolderError
from .raw_folder import raw_files as raw_files, read_raw as read_raw, write_raw as write_raw
from .whole_files import (
    make_folder as make_folder,
    remove_unfinished as remove_unfinished,
    settle as settle,
    whole_folder as whole_folder,
    write_set as write_set,
    write_whole as write_whole,
)
